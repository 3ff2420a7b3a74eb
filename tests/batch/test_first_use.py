"""The compiled arithmetic is compiled by another process, once, and that is said."""

import ctypes
import os
import subprocess
import sys
import time
from hashlib import sha256
from subprocess import CompletedProcess

import pytest

pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")

from numba.core import config, errors

from zoh.batch import first_use
from zoh.batch.compiled import kernel, machine
from zoh.batch.compiled.addresses import numbers
from zoh.batch.compiled.jit import object_file

CODE = b"code\n\0and more"


def whole(name, code):
    rest = name + b"\n" + code
    return sha256(rest).hexdigest().encode() + b"\n" + rest


@pytest.fixture
def begun(monkeypatch, tmp_path):
    """Return the commands that are begun, each keeping a file, and the two where it may be."""
    files = tmp_path / "beside" / "kernel.o", tmp_path / "own" / "kernel.o"
    commands, does = [], {"code": 0, "keeps": whole(b"name", CODE)}
    for file in files:
        file.parent.mkdir()

    def run(command, check, stderr):
        assert not check
        assert stderr == subprocess.DEVNULL  # one line says that it failed
        commands.append(command)
        if not does["code"] and "compile_and_keep" in command[2]:
            files[0].write_bytes(does["keeps"])
        return CompletedProcess(command, does["code"])

    monkeypatch.setattr(first_use, "_files", lambda: files)
    monkeypatch.setattr(first_use.subprocess, "run", run)
    monkeypatch.setattr(machine, "loaded", lambda name, code: (name, code))
    first_use._kernel.cache_clear()
    yield commands, files, does
    first_use._kernel.cache_clear()


def test_another_process_compiles_once(begun, capsys):
    commands, _, _ = begun
    assert first_use.kernel() == ("name", CODE)
    first_use.kernel()
    assert len(commands) == 1
    assert commands[0][:2] == [sys.executable, "-c"]
    said = capsys.readouterr()
    assert not said.out
    assert said.err.splitlines() == [
        "zoh: compiling the fast arithmetic, once: some two minutes ...", "zoh: compiled",
    ]  # fmt: skip


@pytest.mark.parametrize("place", [0, 1])
def test_what_is_kept_is_not_compiled_again(begun, capsys, place):
    commands, files, _ = begun
    files[place].write_bytes(whole(b"a", b"b"))
    assert first_use.kernel() == ("a", b"b")
    assert not commands
    assert not capsys.readouterr().err


@pytest.mark.parametrize(
    "damage",
    [
        lambda a: b"",
        lambda a: a[:-1],
        lambda a: a[:-1] + b"?",
        lambda a: a.replace(b"\na\n", b"\nb\n"),
    ],
)
def test_what_is_damaged_is_made_again(begun, damage):
    commands, files, _ = begun
    files[0].write_bytes(damage(whole(b"a", CODE)))
    assert first_use.kernel() == ("name", CODE)
    assert len(commands) == 1
    files[1].write_bytes(damage(whole(b"a", CODE)))
    with pytest.raises(OSError, match="is damaged"):
        first_use.try_it(str(files[1]))


@pytest.mark.parametrize("fails", [{"code": 1}, {"keeps": b"half"}])
def test_where_that_process_fails_this_one_goes_on(begun, capsys, monkeypatch, fails):
    _, _, does = begun
    does |= fails
    monkeypatch.setattr(kernel, "machine_code", lambda: ("here", b""))
    assert first_use.kernel() == ("here", b"")
    assert capsys.readouterr().err.splitlines()[-1] == "zoh: compiling here instead"


def test_what_was_made_is_tried_before_it_is_kept(begun, monkeypatch):
    commands, (file, own), does = begun
    monkeypatch.setattr(kernel, "machine_code", lambda: ("new", CODE))
    does["code"] = 1
    with pytest.raises(OSError, match="does not run"):
        first_use.compile_and_keep()
    assert not list(file.parent.iterdir())
    does["code"] = 0
    first_use.compile_and_keep()
    assert file.read_bytes() == whole(b"new", CODE)
    assert list(file.parent.iterdir()) == [file]
    assert not list(own.parent.iterdir())
    assert all("try_it" in command[2] for command in commands)
    assert str(os.getpid()) in commands[0][2]  # of two that compile neither writes the other's


def test_where_the_sources_folder_is_closed_it_is_kept_in_ones_own(begun, monkeypatch):
    _, (_, own), _ = begun
    own.parent.rmdir()
    closed = str(own.parent.with_name("beside"))
    monkeypatch.setattr(first_use.os, "access", lambda folder, how: str(folder) != closed)
    monkeypatch.setattr(kernel, "machine_code", lambda: ("new", CODE))
    first_use.compile_and_keep()
    assert own.read_bytes() == whole(b"new", CODE)


def test_code_without_its_function_is_made_again(begun, monkeypatch):
    commands, files, _ = begun
    files[0].write_bytes(whole(b"another", CODE))

    def loaded(name, code):
        if name == "another":
            raise LookupError(name)
        return name, code

    monkeypatch.setattr(machine, "loaded", loaded)
    assert first_use.kernel() == ("name", CODE)
    assert len(commands) == 1


DAY = 86400


def test_what_nobody_loads_any_more_is_removed_and_nothing_else(begun, monkeypatch):
    file = begun[1][0]
    monkeypatch.setattr(kernel, "machine_code", lambda: ("new", CODE))
    folder = file.parent
    for name, days in (("kernel-1.o", 91), ("kernel-2.o", 89), ("kernel-3.77", 91), ("a.pyc", 999)):
        (folder / name).write_bytes(b"")
        old = time.time() - days * DAY
        os.utime(folder / name, (old, old))
    first_use.compile_and_keep()
    assert {f.name for f in folder.iterdir()} == {file.name, "kernel-2.o", "a.pyc"}


def test_what_is_loaded_is_dated_anew(begun):
    _, files, _ = begun
    files[1].write_bytes(whole(b"a", b"b"))
    os.utime(files[1], (0, 0))
    assert first_use.kernel() == ("a", b"b")
    assert files[1].stat().st_mtime > time.time() - DAY


def test_a_start_needs_no_numba():
    code = (
        "import sys\n"
        "from zoh.batch.compiled import run\n"
        "from zoh.batch import first_use\n"
        "first_use._files()\n"
        "print('numba' in sys.modules, 'llvmlite' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]


def _writes(a, b, c, d, e, f, g, h, i, j, k, m, n, o, p, q, r, s, factor):
    from_b = b + c + d + e + f + g + h + i + j + k + m + n + o + p + q + r + s
    numbers(a)[0] = factor * from_b


def test_machine_code_is_a_function_of_addresses():
    before = config.SLP_VECTORIZE
    name, code = object_file(_writes, machine.WHOLES)
    assert config.SLP_VECTORIZE == before
    place = ctypes.c_double()
    machine.loaded(name, code)(ctypes.addressof(place), *range(2, 1 + machine.WHOLES), 0.25)
    assert place.value == 0.25 * sum(range(2, 1 + machine.WHOLES))


def test_code_that_has_not_the_function_is_refused():
    _, code = object_file(_writes, machine.WHOLES)
    with pytest.raises(LookupError, match="has no function nothing"):
        machine.loaded("nothing", code)


def _cannot(a, b, c, d, e, f, g, h, i, j, k, m, n, o, p, q, r, s, factor):
    return a + "text"  # numba has no such sum


@pytest.mark.parametrize("before", [0, 1])
def test_the_setting_is_as_it_was_after_what_cannot_be_compiled(monkeypatch, before):
    monkeypatch.setattr(config, "SLP_VECTORIZE", before)
    with pytest.raises(errors.TypingError):
        object_file(_cannot, machine.WHOLES)
    assert before == config.SLP_VECTORIZE

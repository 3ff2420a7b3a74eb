"""The compiled arithmetic is compiled by another process, once, and that is said."""

import ctypes
import os
import subprocess
import sys
from subprocess import CompletedProcess

import pytest

pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")

from numba.core import config

from zoh.batch import first_use
from zoh.batch.compiled import kernel, machine
from zoh.batch.compiled.addresses import numbers
from zoh.batch.compiled.jit import object_file


@pytest.fixture
def begun(monkeypatch, tmp_path):
    """Return the commands that are begun, each keeping a file; it is looked for in tmp_path."""
    commands, file = [], tmp_path / "kernel.o"
    does = {"code": 0}

    def run(command, check, stderr):
        assert not check
        assert stderr == subprocess.DEVNULL  # one line says that it failed
        commands.append(command)
        if not does["code"]:
            file.write_bytes(b"name\ncode\nand more")
        return CompletedProcess(command, does["code"])

    monkeypatch.setattr(first_use, "_file", lambda: file)
    monkeypatch.setattr(first_use.subprocess, "run", run)
    monkeypatch.setattr(machine, "loaded", lambda name, code: (name, code))
    first_use.kernel.cache_clear()
    yield commands, file, does
    first_use.kernel.cache_clear()


def test_another_process_compiles_once(begun, capsys):
    commands, _, _ = begun
    assert first_use.kernel() == ("name", b"code\nand more")
    first_use.kernel()
    assert len(commands) == 1
    assert commands[0][:2] == [sys.executable, "-c"]
    assert "compile_and_keep" in commands[0][2]
    said = capsys.readouterr()
    assert not said.out
    assert said.err.splitlines() == [
        "zoh: compiling the fast arithmetic, once: some two minutes ...", "zoh: compiled",
    ]  # fmt: skip


def test_what_is_kept_is_not_compiled_again(begun, capsys):
    commands, file, _ = begun
    file.write_bytes(b"a\nb")
    assert first_use.kernel() == ("a", b"b")
    assert not commands
    assert not capsys.readouterr().err


def test_where_that_process_fails_this_one_goes_on(begun, capsys, monkeypatch):
    _, _, does = begun
    does["code"] = 1
    monkeypatch.setattr(kernel, "machine_code", lambda: ("here", b""))
    assert first_use.kernel() == ("here", b"")
    assert capsys.readouterr().err.splitlines()[-1] == "zoh: compiling here instead"


def test_what_was_made_is_tried_before_it_is_kept(begun, monkeypatch):
    commands, file, does = begun
    monkeypatch.setattr(kernel, "machine_code", lambda: ("new", b"\n\0code"))
    does["code"] = 1
    with pytest.raises(OSError, match="does not run"):
        first_use.compile_and_keep()
    assert not list(file.parent.iterdir())
    does["code"] = 0
    first_use.compile_and_keep()
    assert file.read_bytes() == b"new\n\n\0code"
    assert list(file.parent.iterdir()) == [file]
    assert all("try_it" in command[2] for command in commands)
    assert str(os.getpid()) in commands[0][2]  # of two that compile neither writes the other's


def test_a_start_needs_no_numba():
    code = (
        "import sys\n"
        "from zoh.batch.compiled import run\n"
        "from zoh.batch import first_use\n"
        "first_use._file()\n"
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

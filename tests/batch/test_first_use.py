"""The compiled arithmetic is compiled by another process, once, and that is said."""

import sys
from subprocess import CompletedProcess

import pytest

pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")

from zoh.batch import backend, first_use


@pytest.fixture
def begun(monkeypatch, tmp_path):
    """Return the commands that are begun; the mark is looked for in a folder of the test's."""
    commands, mark = [], tmp_path / "mark"
    code = {"code": 0}

    def run(command, check, stderr):
        assert not check
        assert stderr == first_use.subprocess.DEVNULL  # one line says that it failed
        commands.append(command)
        return CompletedProcess(command, code["code"])

    monkeypatch.setattr(first_use, "_mark", lambda: mark)
    monkeypatch.setattr(first_use.subprocess, "run", run)
    first_use.ready.cache_clear()
    yield commands, mark, code
    first_use.ready.cache_clear()


def test_another_process_compiles_once(begun, capsys):
    commands, _, _ = begun
    first_use.ready()
    first_use.ready()
    assert len(commands) == 1
    assert commands[0][:2] == [sys.executable, "-c"]
    assert "compile_and_mark" in commands[0][2]
    said = capsys.readouterr()
    assert not said.out
    assert said.err.splitlines() == [
        "zoh: compiling the fast arithmetic, once: some three minutes ...", "zoh: compiled",
    ]  # fmt: skip


def test_what_is_kept_is_not_compiled_again(begun, capsys):
    commands, mark, _ = begun
    mark.touch()
    first_use.ready()
    assert not commands
    assert not capsys.readouterr().err


def test_where_that_process_fails_this_one_goes_on(begun, capsys):
    _, _, code = begun
    code["code"] = 1
    first_use.ready()
    assert capsys.readouterr().err.splitlines()[-1] == "zoh: compiling here instead"


def test_a_way_is_made_ready_before_it_runs(monkeypatch):
    order = []
    monkeypatch.setattr(first_use, "ready", lambda: order.append("ready"))
    monkeypatch.setattr("zoh.batch.compiled.run.run", lambda job, columns: order.append("run"))
    backend.COMPILED.run(None, {})
    assert order == ["ready", "run"]

"""The bar of a proof: on a terminal it says where it is, elsewhere nothing is written."""

import pytest

import zoh
from zoh.app.proving import proving
from zoh.firmware import prove as proof


@pytest.fixture
def plan():
    return zoh.plan(zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45), name="loop")


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    def fake(made, progress):
        for done in range(1, 4):
            progress(done, 3, f"Cortex-M{done} -O2")
        return made

    monkeypatch.setattr(proof, "prove", fake)


def test_a_terminal_is_told_which_build_is_done(plan, monkeypatch, capsys):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    with proving(True) as prove:
        assert prove(plan) is plan
    out, err = capsys.readouterr()
    assert out == ""
    assert "loop: Cortex-M3 -O2" in err
    assert "3/3" in err


def test_nobody_else_is(plan, monkeypatch, capsys):
    monkeypatch.setenv("TTY_COMPATIBLE", "0")
    with proving(True) as prove:
        prove(plan)
    assert capsys.readouterr() == ("", "")


def test_without_a_proof_there_is_nothing_to_do():
    with proving(False) as prove:
        assert prove is None

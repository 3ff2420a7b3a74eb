"""A sweep on disk is the sweep in memory, also after it was killed at any moment."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import zoh
from zoh.batch.figures import column_names
from zoh.batch.job import Job
from zoh.batch.space import Random, Rows
from zoh.batch.spread import Normal, Uniform
from zoh.batch.stream import open_sweep, sweep_to
from zoh.batch.sweep import sweep, sweep_summary

pytest.importorskip("zarr")
pytest.importorskip("xarray")

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
JOB = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc", "plant.gain"))
SPREADS = {"wc": Uniform(low=0.2, high=1.6), "plant.gain": Normal(mean=2.3, sd=0.2)}
ASKED = zoh.Requirements(ms=1.9)
KEPT = ["wc", "ms", "stable", "reason"]


def space(count):
    return Random(spreads=SPREADS, count=count, seed=11)


def contents(folder):
    """Return a digest of every file of a store by its place in it."""
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in Path(folder).rglob("*")
        if file.is_file()
    }


def test_a_store_holds_what_a_sweep_in_memory_has(tmp_path):
    told, path = [], str(tmp_path / "a.zarr")
    # the single design does one loop after the other, so its bits know no block; those of arrays
    # may differ in the last one with the length of a block
    asked = {"requirements": ASKED, "arithmetic": "single"}
    found = sweep_to(
        path, JOB, space(50), block=16,
        progress=lambda done, loops: told.append((done, loops)), **asked,
    )  # fmt: skip
    held = sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over=space(50), **asked)
    assert found == held.summary == sweep_summary(JOB, space(50), block=7, **asked)
    assert told == [(0, 50), (16, 50), (32, 50), (48, 50), (50, 50)]
    with open_sweep(path) as stored:
        assert set(stored) == {*JOB.varying, *column_names("pi")}
        for name in stored:
            assert np.array_equal(stored[name].values, held[name], equal_nan=name != "stable")
        assert stored["ms"].attrs["long_name"] == "peak of the sensitivity, Ms"
        assert stored["phase_margin_deg"].attrs["units"] == "deg"


def test_a_store_that_is_whole_is_not_touched_again(tmp_path):
    path = str(tmp_path / "a.zarr")
    first = sweep_to(path, JOB, space(20), block=8)
    before, times = contents(path), [os.stat(f).st_mtime_ns for f in Path(path).rglob("*")]
    assert sweep_to(path, JOB, space(20), block=8) == first
    assert contents(path) == before
    assert [os.stat(f).st_mtime_ns for f in Path(path).rglob("*")] == times


def test_a_first_write_that_did_not_end_is_no_store(tmp_path):
    folder = tmp_path / "a.zarr"
    folder.mkdir()
    (folder / "zarr.json.1234.partial").write_text("{")
    assert sweep_to(str(folder), JOB, space(10)).loops == 10
    assert not list(folder.rglob("*.partial"))


def test_a_download_that_did_not_end_is_not_ours_to_remove(tmp_path):
    (tmp_path / "film.partial").write_text("half")
    with pytest.raises(zoh.SpecError, match=r"must be new, .* but it has no zarr\.json"):
        sweep_to(str(tmp_path), JOB, space(10))
    assert [f.read_text() for f in tmp_path.iterdir()] == ["half"]


def test_a_folder_that_cannot_be_made_is_refused_in_one_line(tmp_path):
    (tmp_path / "file").write_text("no folder")
    path = str(tmp_path / "file" / "a.zarr")
    held = sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over=space(3))
    for write in (lambda: sweep_to(path, JOB, space(3)), lambda: held.to_zarr(path)):
        with pytest.raises(zoh.SpecError, match="must be a folder that can be made") as refused:
            write()
        assert "\n" not in str(refused.value)


def test_a_block_beyond_the_loops_is_all_of_them(tmp_path):
    path = str(tmp_path / "a.zarr")
    first = sweep_to(path, JOB, space(3), block=10**12)  # 8 TB a column
    before = contents(path)
    assert sweep_to(path, JOB, space(3), block=3) == sweep_to(path, JOB, space(3)) == first
    assert contents(path) == before


def test_only_what_is_asked_for_is_kept(tmp_path):
    path = str(tmp_path / "a.zarr")
    sweep_to(path, JOB, space(10), keep=["ms", "wc"])
    with open_sweep(path) as stored:
        assert set(stored) == {"ms", "wc"}
    with pytest.raises(zoh.SpecError, match="keep must name columns"):
        sweep_to(str(tmp_path / "b.zarr"), JOB, space(10), keep=["mss"])


def test_another_sweep_or_a_strange_folder_is_refused(tmp_path):
    path = str(tmp_path / "a.zarr")
    sweep_to(path, JOB, space(10))
    other = Job(plant=ARM, law="pi", asked={"pm_deg": 41}, dt=0.1, varying=JOB.varying)
    for job, over in (
        (other, space(10)),
        (JOB, space(11)),
        (JOB, Rows(values=space(10).columns(0, 10))),
    ):
        with pytest.raises(zoh.SpecError, match="must be new, or hold the same sweep"):
            sweep_to(path, job, over)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(zoh.SpecError, match="must be new, or hold the same sweep"):
        sweep_to(str(tmp_path / "mine"), JOB, space(10))
    assert contents(tmp_path / "mine").keys() == {"letter.txt"}


CHILD = """
import sys
sys.path.insert(0, sys.argv[2])
from test_stream import ASKED, JOB, KEPT, space
from zoh.batch.stream import sweep_to
sweep_to(sys.argv[1], JOB, space(400), requirements=ASKED, block=8, keep=KEPT)
"""


def start(path):
    return subprocess.Popen([sys.executable, "-c", CHILD, path, str(Path(__file__).parent)])


def test_a_sweep_that_is_killed_again_and_again_comes_to_the_same_bits(tmp_path):
    whole, cut = str(tmp_path / "whole.zarr"), str(tmp_path / "cut.zarr")
    expected = sweep_to(whole, JOB, space(400), requirements=ASKED, block=8, keep=KEPT)
    moments = np.random.default_rng(5)
    blocks, seen = Path(cut) / "blocks" / "c", []
    for _ in range(3):
        child = start(cut)
        begun = len(list(blocks.glob("*"))) if blocks.exists() else 0
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and child.poll() is None:
            if blocks.exists() and len(list(blocks.glob("*"))) > begun + 2:
                break  # it is at work: now at any moment
            time.sleep(0.005)
        time.sleep(moments.uniform(0, 0.03))
        child.send_signal(signal.SIGKILL)
        child.wait()
        seen.append(len(list(blocks.glob("*"))))
    assert seen == sorted(seen)
    assert 0 < seen[0] < 50  # the first one was cut in the middle
    assert sweep_to(cut, JOB, space(400), requirements=ASKED, block=8, keep=KEPT) == expected
    assert contents(cut) == contents(whole)

"""Every file of a store, lost, cut or garbled: told in one line, mended by the same sweep."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import zoh
from zoh.batch.job import Job
from zoh.batch.space import Random, Rows
from zoh.batch.spread import Normal, Uniform
from zoh.batch.stream import open_sweep, sweep_to

pytest.importorskip("zarr")
xarray = pytest.importorskip("xarray")

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
JOB = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc", "plant.gain"))
SPREADS = {"wc": Uniform(low=0.2, high=1.6), "plant.gain": Normal(mean=2.3, sd=0.2)}
KEPT = ["wc", "ms", "stable", "reason"]


def space(count=10):
    return Random(spreads=SPREADS, count=count, seed=11)


def swept(path):
    return sweep_to(str(path), JOB, space(), block=4, keep=KEPT, arithmetic="single")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return (the folder of a store that is whole, its summary)."""
    path = tmp_path_factory.mktemp("whole") / "a.zarr"
    return path, swept(path)


def contents(folder):
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in Path(folder).rglob("*")
        if file.is_file()
    }


def flipped(old):
    middle = len(old) // 2
    return old[:middle] + bytes([old[middle] ^ 1]) + old[middle + 1 :]


DAMAGES = {
    "deleted": None,
    "cut": lambda old: old[: len(old) // 2],
    "emptied": lambda old: b"",
    "garbled": lambda old: bytes(np.random.default_rng(3).integers(0, 256, len(old), np.uint8)),
    "longer": lambda old: old + b"\n{",
    "a bit flipped": flipped,
}


def damaged(file, damage):
    if DAMAGES[damage] is None:
        file.unlink()
    else:
        file.write_bytes(DAMAGES[damage](file.read_bytes()))


PLACES = (
    "zarr.json",
    *(f"{name}/zarr.json" for name in (*KEPT, "blocks")),
    *(f"{name}/c/{k}" for name in KEPT for k in range(3)),
    *(f"blocks/c/{k}/0" for k in range(3)),
)


def test_these_are_all_the_files_of_a_store(whole):
    assert set(contents(whole[0])) == set(PLACES)


def refused(path, *said):
    """Assert that reading all of a store is refused in one line with these words."""
    with pytest.raises(zoh.SpecError) as told, open_sweep(str(path)) as stored:
        stored.load()
    line = str(told.value)
    assert "\n" not in line
    assert told.value.value == str(path)
    for words in said:
        assert words in line


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("place", PLACES)
def test_damage_is_told_in_one_line_and_mended_to_the_same_bits(whole, tmp_path, place, damage):
    path = tmp_path / "a.zarr"
    shutil.copytree(whole[0], path)
    damaged(path / place, damage)
    refused(path, place)
    if place == "zarr.json":  # with it the store has lost what it is of
        before = contents(path)
        with pytest.raises(zoh.SpecError, match=r"its zarr.json is damaged|it has no zarr.json"):
            swept(path)
        assert contents(path) == before
    else:
        assert swept(path) == whole[1]
        assert contents(path) == contents(whole[0])


def test_no_block_passes_for_another(whole, tmp_path):
    """Block 0 copied over block 1, row and columns: its loops would be counted twice."""
    path = tmp_path / "a.zarr"
    shutil.copytree(whole[0], path)
    for place in ("blocks/c/{}/0", *(f"{name}/c/{{}}" for name in KEPT)):
        shutil.copyfile(path / place.format(0), path / place.format(1))
    refused(path, "blocks/c/1/0")
    assert swept(path) == whole[1]
    assert contents(path) == contents(whole[0])


def test_no_block_of_another_sweep_passes_for_this_one_s(whole, tmp_path):
    other, mixed = tmp_path / "other.zarr", tmp_path / "mixed.zarr"
    seeded = Random(spreads=SPREADS, count=10, seed=12)
    sweep_to(str(other), JOB, seeded, block=4, keep=KEPT, arithmetic="single")
    shutil.copytree(whole[0], mixed)
    for place in (*(f"{name}/c/1" for name in KEPT), "blocks/c/1/0"):
        shutil.copy(other / place, mixed / place)
    refused(mixed, "blocks/c/1/0")
    assert swept(mixed) == whole[1]
    assert contents(mixed) == contents(whole[0])


def test_what_is_no_file_of_the_sweep_is_no_column_of_it(whole, tmp_path):
    more = tmp_path / "more.zarr"
    shutil.copytree(whole[0], more)
    shutil.copytree(more / "ms", more / "mt")
    assert set(open_sweep(str(more)).variables) == set(KEPT)


def test_a_block_of_nothing_has_no_file_and_is_whole(tmp_path):
    """Zarr writes no chunk of fill values alone; that one of these is missing is no damage."""
    path = tmp_path / "a.zarr"
    job = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    over = Rows(values={"wc": [0.5, 0.6, 3.0, 4.0]})  # of the last two none is feasible
    found = sweep_to(str(path), job, over, block=2, keep=["ms", "reason"])
    assert not (path / "ms" / "c" / "1").exists()
    with open_sweep(str(path)) as stored:
        assert np.isnan(stored["ms"].values).tolist() == [False, False, True, True]
        assert stored["reason"].values.tolist() == [0, 0, 1, 1]
    (path / "ms" / "c" / "1").write_bytes((path / "ms" / "c" / "0").read_bytes())
    refused(path, "ms/c/1")
    assert sweep_to(str(path), job, over, block=2, keep=["ms", "reason"]) == found
    with open_sweep(str(path)) as stored:
        assert np.isnan(stored["ms"].values).tolist() == [False, False, True, True]


def test_a_store_that_is_not_complete_says_what_is_missing(tmp_path):
    def stopped(done, loops):
        if done >= 4:
            raise KeyboardInterrupt

    path = str(tmp_path / "a.zarr")
    with pytest.raises(KeyboardInterrupt):
        sweep_to(path, JOB, space(40), block=4, keep=KEPT, progress=stopped)
    refused(
        path,
        "must be a whole store, not one with blocks/c/1/0, blocks/c/2/0, blocks/c/3/0 and 6 more",
    )


@pytest.mark.parametrize("grid", [True, False])
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_sweep_that_was_held_is_saved_with_its_seals(tmp_path, grid, damage):
    over = {"wc": [0.4, 0.5], "plant.gain": [2.0, 2.3]} if grid else space(5)
    held = zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over=over)
    path = tmp_path / "a.zarr"
    held.to_zarr(str(path))
    with open_sweep(str(path)) as stored:
        xarray.testing.assert_identical(stored.load().drop_attrs(), held.dataset.drop_attrs())
    for place, old in contents(path).items():
        damaged(path / place, damage)
        refused(path, place)
        (path / place).write_bytes(old)


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (lambda path: None, "it is not there"),
        (lambda path: path.mkdir(), "it has no zarr.json"),
        (lambda path: path.write_text("{}"), "it has no zarr.json"),
        (
            lambda path: xarray.Dataset({"a": ("x", [1.0])}).to_zarr(path, consolidated=False),
            "it holds no sweep",
        ),
        (
            lambda path: xarray.Dataset(attrs={"zoh": "0.1"}).to_zarr(path, consolidated=False),
            "it holds no sweep",
        ),
    ],
)
def test_what_is_no_store_is_said_in_one_line(tmp_path, made, why):
    made(tmp_path / "a.zarr")
    refused(tmp_path / "a.zarr", "path must be a sweep's store, but " + why)
    with pytest.raises(zoh.SpecError, match="path must be a path, got 3"):
        open_sweep(3)


ELSE = zoh.Plant(num=[2.3], den=[1, 0.75, 0], sensor=12 / 180)
DIGITS = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)  # the decimals, not their floats
OTHERS = [
    ({"asked": {"pm_deg": 41}}, {}, "its asked is {'pm_deg': 40.0}, not {'pm_deg': 41.0}, got"),
    ({"law": "pd"}, {}, "its law is pi, not pd"),
    ({"plant": ELSE}, {}, "its plant is ...2.3,), den=(1.0, 0.7809, 0.0), "),
    ({"plant": DIGITS}, {}, "its plant_digits is"),
    ({"dt": 0.2}, {}, "its dt is 0.1, not 0.2"),
    ({"compute_delay": 0.01}, {}, "its compute_delay is 0.0, not 0.01"),
    ({"reference": 2.0}, {}, "its reference is 1.0, not 2.0"),
    ({"sections": [zoh.notch(w0=9.0)]}, {}, 'its sections is [], not [{"zeros_w0": 9.0,'),
    ({}, {"over": space(11)}, "its over is "),
    ({}, {"over": Rows(values=space().columns(0, 10))}, "not Rows of 10 of wc, 10 of plant.gain"),
    ({}, {"requirements": zoh.Requirements(ms=2)}, "its requirements is {}, not {'ms': 2.0}"),
    ({}, {"keep": ["ms"]}, """its keep is ["wc", "ms", "stable", "reason"], not ["ms"]"""),
    ({}, {"block": 5}, "its block is 4, not 5"),
    ({}, {"arithmetic": "arrays"}, "its arithmetic is single, not arrays"),
    pytest.param(
        {}, {"arithmetic": "compiled"}, "its arithmetic is single, not compiled, got",
        marks=pytest.mark.skipif(not find_spec("numba"), reason="compiled needs numba"),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("of_job", "of_sweep", "said"), OTHERS)
def test_another_sweep_is_refused_with_what_differs(whole, of_job, of_sweep, said):
    path, _ = whole
    before = contents(path)
    job = {"plant": ARM, "law": "pi", "asked": {"pm_deg": 40}, "dt": 0.1, "varying": JOB.varying}
    asked = {"over": space(), "block": 4, "keep": KEPT, "arithmetic": "single"}
    with pytest.raises(zoh.SpecError) as refused:
        sweep_to(str(path), Job(**{**job, **of_job}), **{**asked, **of_sweep})
    assert said in str(refused.value)
    assert "path must be new, or hold the same sweep, but its " in str(refused.value)
    assert str(refused.value).endswith(": name another folder, or ask for what it holds")
    assert contents(path) == before

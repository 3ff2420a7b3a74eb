"""What a sweep runs over, by facts that are known by hand or from the standard library."""

from itertools import product
from statistics import NormalDist

import numpy as np
import pytest

import zoh
from zoh.batch import draws
from zoh.batch.space import Grid, Random, Rows, as_space, corners
from zoh.batch.spread import LogUniform, Normal, Uniform, standard_normal

MANY = 200_000
ALIKE = Uniform(low=0.0, high=1.0)


def sample(spread, latin=False, seed=3, count=MANY):
    return Random(spreads={"wc": spread}, count=count, seed=seed, latin=latin).columns(0, count)[
        "wc"
    ]


def test_a_grid_is_every_combination_in_the_order_of_itertools():
    axes = {"wc": [1.0, 2.0, 3.0], "dt": [0.1, 0.2], "ki": [5.0, 6.0]}
    grid = Grid(axes=axes)
    found = grid.columns(0, grid.size)
    rows = list(zip(*(found[k].tolist() for k in axes), strict=True))
    assert rows == list(product(*axes.values()))
    assert (grid.size, grid.shape, grid.keys) == (12, (3, 2, 2), ("wc", "dt", "ki"))


def test_corners_are_the_ends_of_each_spread():
    grid = corners({"wc": Uniform(low=1, high=2), "dt": LogUniform(low=0.1, high=1)})
    found = grid.columns(0, 4)
    assert list(zip(found["wc"].tolist(), found["dt"].tolist(), strict=True)) == [
        (1.0, 0.1), (1.0, 1.0), (2.0, 0.1), (2.0, 1.0),
    ]  # fmt: skip


@pytest.mark.parametrize("latin", [False, True])
def test_any_stretch_is_the_same_wherever_it_is_made(latin):
    spreads = {"wc": Normal(mean=1, sd=0.1), "dt": LogUniform(low=1e-3, high=1e-1)}
    space = Random(spreads=spreads, count=1000, seed=5, latin=latin)
    whole = space.columns(0, 1000)
    for start, stop in ((0, 1), (3, 10), (1, 999), (997, 1000), (400, 400)):
        part = space.columns(start, stop)
        for key in spreads:
            assert (part[key] == whole[key][start:stop]).all()


def test_a_column_knows_its_seed_and_its_key_alone():
    alone = sample(ALIKE, count=50)
    beside = Random(spreads={"dt": ALIKE, "wc": ALIKE}, count=50, seed=3).columns(0, 50)
    assert (beside["wc"] == alone).all()
    assert not (beside["dt"] == alone).any()
    assert not (sample(ALIKE, seed=4, count=50) == alone).any()


# standard errors of the statistics below, times 4: one seed in 16 000 would be outside
def test_a_uniform_sample_has_the_moments_of_a_uniform():
    x = sample(Uniform(low=2.0, high=5.0))
    assert x.min() > 2.0
    assert x.max() < 5.0
    assert x.mean() == pytest.approx(3.5, abs=4 * 3 / np.sqrt(12 * MANY))
    assert x.var() == pytest.approx(9 / 12, abs=4 * 9 * np.sqrt(1 / 180 / MANY))


def test_a_normal_sample_has_the_moments_and_the_quantiles_of_a_normal():
    x = sample(Normal(mean=10.0, sd=2.0))
    assert x.mean() == pytest.approx(10.0, abs=4 * 2 / np.sqrt(MANY))
    assert x.var() == pytest.approx(4.0, abs=4 * 4 * np.sqrt(2 / MANY))
    for share in (0.01, 0.1587, 0.5, 0.8413, 0.99):
        below = np.mean(x < NormalDist(10, 2).inv_cdf(share))
        assert below == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / MANY))


def test_a_log_uniform_sample_is_uniform_in_the_logarithm():
    x = np.log10(sample(LogUniform(low=1e-5, high=1e-1)))
    assert x.mean() == pytest.approx(-3.0, abs=4 * 4 / np.sqrt(12 * MANY))
    counts = np.histogram(x, bins=4, range=(-5, -1))[0]
    assert counts == pytest.approx(MANY / 4, abs=4 * np.sqrt(MANY * 3 / 16))


def test_two_keys_are_independent():
    found = Random(spreads={"wc": ALIKE, "dt": ALIKE}, count=MANY, seed=1).columns(0, MANY)
    assert abs(np.corrcoef(found["wc"], found["dt"])[0, 1]) < 4 / np.sqrt(MANY)
    found = Random(spreads={"wc": ALIKE, "dt": ALIKE}, count=4096, seed=1, latin=True)
    both = found.columns(0, 4096)
    assert abs(np.corrcoef(both["wc"], both["dt"])[0, 1]) < 4 / np.sqrt(4096)


@pytest.mark.parametrize("count", [1, 2, 3, 10, 64, 1000, 4097])
def test_a_latin_hypercube_has_every_cell_once(count):
    x = sample(ALIKE, latin=True, count=count)
    assert sorted(np.floor(x * count).tolist()) == list(range(count))


def test_a_latin_hypercube_has_a_smaller_error_of_the_mean():
    # the mean of a cell is off by 1/count/sqrt(12) at most: the error falls as count^-1.5
    x = sample(ALIKE, latin=True, count=10_000)
    assert abs(x.mean() - 0.5) < 4 / np.sqrt(12) / 10_000**1.5


@pytest.mark.parametrize("count", [2, 7, 16, 100])
def test_places_are_permuted_without_a_fixed_order(count):
    orders = {tuple(draws.permuted(seed, "wc", count, 0, count).tolist()) for seed in range(30)}
    assert all(sorted(order) == list(range(count)) for order in orders)
    assert len(orders) > (1 if count == 2 else 25)


def test_the_normal_inverse_is_the_standard_library_s():
    shares = [1e-300, 1e-20, 1e-5, 0.024, 0.075, 0.3, 0.5, 0.75, 0.93, 0.9999, 1 - 1e-15]
    found = standard_normal(np.array(shares))
    assert found == pytest.approx([NormalDist().inv_cdf(p) for p in shares], rel=1e-13, abs=1e-15)


def test_draws_are_never_at_an_end():
    x = draws.uniform(0, "wc", 0, MANY)
    assert x.min() > 0
    assert x.max() < 1


@pytest.mark.parametrize(
    ("wide", "argument"),
    [
        (lambda: Uniform(low=-1.5e308, high=1.5e308), "high"),
        (lambda: LogUniform(low=1e-300, high=1e300), "high"),
        (lambda: Normal(mean=1.7e308, sd=1e308), "sd"),
    ],
)
def test_a_spread_whose_draws_are_beyond_a_float_is_refused(wide, argument):
    with pytest.raises(zoh.SpecError, match=r"must leave every draw of .* a float, got") as refused:
        wide()
    assert refused.value.argument == argument
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("spread", [Uniform, LogUniform])
def test_a_spread_of_no_width_is_said_to_vary_nothing(spread):
    with pytest.raises(zoh.SpecError, match=r"above low = 2\.0, got 2\.0: nothing varies"):
        spread(low=2, high=2)
    with pytest.raises(zoh.SpecError, match=r"above low = 2\.0, got 1\.0: swap the two"):
        spread(low=2, high=1)


def test_a_spread_as_wide_as_a_float_allows_is_drawn():
    x = sample(Uniform(low=-8e307, high=8e307))
    assert np.isfinite(x).all()
    assert x.min() < -7.9e307 < 7.9e307 < x.max()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Grid(axes={}),
        lambda: Grid(axes={"wc": []}),
        lambda: Grid(axes={"wc": [np.nan]}),
        lambda: Grid(axes={str(i): np.arange(1000.0) for i in range(6)}),
        lambda: Rows(values={"wc": [1.0, 2.0], "dt": [1.0]}),
        lambda: Random(spreads={"wc": [1.0]}, count=3),
        lambda: Random(spreads={"wc": ALIKE}, count=0),
        lambda: Random(spreads={"wc": ALIKE}, count=3, seed=-1),
        lambda: Uniform(low=2.0, high=1.0),
        lambda: LogUniform(low=0.0, high=1.0),
        lambda: Normal(mean=1.0, sd=0.0),
        lambda: corners({"wc": Normal(mean=1.0, sd=1.0)}),
        lambda: as_space({"wc": ALIKE}),
        lambda: as_space([1, 2]),
    ],
)
def test_what_is_no_space_is_refused(wrong):
    with pytest.raises(zoh.SpecError):
        wrong()

"""The questions that are asked of a sweep, answered as a loop over single designs would."""

import json
from pathlib import Path

import numpy as np
import pytest

import zoh
from zoh.analysis.asked import missed
from zoh.batch import bounds
from zoh.batch.figures import BY_NAME, FIGURES
from zoh.batch.job import Job
from zoh.batch.result import _undominated
from zoh.batch.summary import Extremes, Summary
from zoh.batch.units import unit_and_name

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
WC, PM = np.linspace(0.2, 4.0, 9), [40.0, 60.0]


@pytest.fixture(scope="module")
def swept():
    return zoh.sweep(ARM, "pd", dt=0.1, over={"wc": WC, "pm_deg": PM})


def test_a_sweep_has_a_loop_for_each_combination(swept):
    assert len(swept) == 18
    assert swept["wc"].tolist() == np.repeat(WC, 2).tolist()
    assert swept["pm_deg"].tolist() == PM * 9
    ok = swept["reason"] == zoh.Reason.OK
    assert swept["phase_margin_deg"][ok] == pytest.approx(swept["pm_deg"][ok], abs=1e-9)
    with pytest.raises(zoh.SpecError, match="must be a column"):
        _ = swept["pm"]


@pytest.mark.parametrize(
    "asked",
    [
        {"pm_deg": 50},
        {"gain_margin_db": 20},
        {"delay_margin": 0.5},
        {"ms": 1.6},
        {"mt": 1.3},
        {"overshoot_pct": 20},
        {"rise_time": 0.7},
        {"settling_time": 3.0},
        {"steady_state_error": 0.1},
        {"peak_effort": 20},
        {"ms": 1.6, "peak_effort": 20},
    ],
)
def test_the_yield_is_the_share_of_single_designs_that_meet_the_requirements(swept, asked):
    requirements, good = zoh.Requirements(**asked), []
    for wc, pm in zip(swept["wc"], swept["pm_deg"], strict=True):
        try:
            d = zoh.pd(ARM, dt=0.1, wc=wc, pm_deg=pm)
        except zoh.Infeasible:
            good.append(False)
        else:
            good.append(not missed(requirements, d.margins, d.step))
    assert 0 < sum(good) < len(good)
    assert swept.yield_(requirements) == sum(good) / len(good)
    assert bounds.met(requirements, swept.results).tolist() == good


def test_a_requirement_that_no_sweep_measures_is_refused(swept):
    with pytest.raises(zoh.SpecError, match="noise_gain must be left out"):
        swept.yield_(zoh.Requirements(noise_gain=1.0))


def test_the_worst_is_named_with_its_loop(swept):
    worst = swept.worst("ms")
    i = int(np.nanargmax(swept["ms"]))
    assert (worst.loop, worst.value) == (i, swept["ms"][i])
    assert worst.at == {"wc": swept["wc"][i], "pm_deg": swept["pm_deg"][i]}
    assert worst.without == np.count_nonzero(swept["reason"] != 0)
    assert swept.worst("phase_margin_deg").value == np.nanmin(swept["phase_margin_deg"])
    with pytest.raises(zoh.SpecError, match="better end"):
        swept.worst("peak_time")
    none = zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [5.0]}).worst("ms")
    assert (none.value, none.loop, none.without) == (None, None, 1)


def test_a_pareto_front_is_what_nothing_beats(swept):
    front = swept.pareto("crossover", "ms", "peak_effort")
    costs = np.column_stack([-swept["crossover"], swept["ms"], swept["peak_effort"]])
    ok = np.flatnonzero(swept["reason"] == 0)
    kept = [
        i
        for i in ok
        if not any((costs[j] <= costs[i]).all() and (costs[j] < costs[i]).any() for j in ok)
    ]
    assert sorted(zip(front["wc"], front["pm_deg"], strict=True)) == sorted(
        zip(swept["wc"][kept], swept["pm_deg"][kept], strict=True)
    )
    assert (np.diff(front["crossover"]) <= 0).all()
    with pytest.raises(zoh.SpecError, match="names must be figures"):
        swept.pareto("peak")


def test_undominated_rows_by_hand():
    costs = np.array([[3, 1.0], [1, 3], [2, 2], [3, 3], [2, 3], [1, 4]])
    assert _undominated(costs).tolist() == [1, 2, 0]


def test_summaries_merge_in_any_order_to_the_same(swept):
    results, asked = swept.results, zoh.Requirements(ms=1.6)
    whole = Summary.of(results, asked)
    cuts = [(0, 5), (5, 6), (6, 18)]
    parts = [Summary.of({k: v[a:b] for k, v in results.items()}, asked, a) for a, b in cuts]
    for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
        found = Summary.nothing()
        for i in order:
            found = found.merged(parts[i])
        assert found == whole
    assert (whole.loops, whole.share) == (18, swept.yield_(asked))
    again = Summary.unpacked(whole.packed())
    assert again == whole
    i = [figure.name for figure in FIGURES].index("ms")
    assert whole.extremes[i].most_at == swept.worst("ms").loop


def test_of_equal_extremes_the_first_loop_is_named():
    early, late = (
        Extremes(least=1.0, least_at=2, most=5.0, most_at=9),
        Extremes(least=1.0, least_at=7, most=5.0, most_at=8),
    )
    merged = Extremes(least=1.0, least_at=2, most=5.0, most_at=8)
    assert early.merged(late) == late.merged(early) == merged
    assert Extremes().merged(early) == early.merged(Extremes()) == early


def test_a_summary_in_json_counts_each_reason(swept):
    said = swept.summary.to_dict()
    assert said["loops"] == 18
    assert sum(said["reasons"].values()) == 18
    assert said["reasons"]["ok"] == said["met"] == np.count_nonzero(swept["reason"] == 0)
    assert set(said["extremes"]) == set(BY_NAME)
    low, high = said["yield_interval_95"]
    assert 0 < low < said["yield"] < high < 1


def test_what_cannot_be_written_leaves_no_half_of_a_file(swept, tmp_path, monkeypatch):
    xarray = pytest.importorskip("xarray")

    def full(dataset, path, engine):
        Path(path).write_bytes(b"half")
        raise OSError("no space left on device")

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", full)
    with pytest.raises(OSError, match="no space left"):
        swept.to_netcdf(str(tmp_path / "a.nc"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("write", ["to_zarr", "to_netcdf"])
def test_what_is_no_path_is_refused(swept, write):
    with pytest.raises(zoh.SpecError, match=r"path must be a path.* 3"):
        getattr(swept, write)(3)


def test_the_dataset_of_a_grid_has_its_axes_and_units(swept, tmp_path):
    xarray = pytest.importorskip("xarray")
    found = swept.dataset
    assert found["ms"].dims == ("wc", "pm_deg")
    i, j = 3, 1
    assert found["ms"].values[i, j] == swept["ms"][2 * i + j]
    assert found["crossover"].attrs == {"long_name": "crossover frequency", "units": "rad/s"}
    assert found["wc"].attrs["units"] == "rad/s"
    assert found["reason"].attrs["flag_meanings"].split()[1] == "infeasible"
    swept.to_netcdf(str(tmp_path / "a.nc"))
    swept.to_zarr(str(tmp_path / "a.zarr"))
    for opened in (
        xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf"),
        xarray.open_zarr(tmp_path / "a.zarr", consolidated=False),
    ):
        with opened:
            xarray.testing.assert_identical(opened.load().drop_attrs(), found.drop_attrs())
    for write in (swept.to_netcdf, swept.to_zarr):
        with pytest.raises(zoh.SpecError, match="must not be there already"):
            write(str(tmp_path / ("a.nc" if write == swept.to_netcdf else "a.zarr")))


JOINT = zoh.Joint(torque_constant=0.5, resistance=2.0, motor_inertia=0.25)
COLUMNS = [
    (ARM, "p", {"wc": 0.5, "pm_deg": 45}),
    (ARM, "pi", {"wc": 0.5, "pm_deg": 40, "setpoint_weight": 0.5}),
    (ARM, "pd", {"wc": 1.5, "pm_deg": 50, "filter_pole": 30.0, "derivative_weight": 0.0}),
    (ARM, "pid", {"wc": 1.5, "pm_deg": 50, "ki": 0.5}),
    (ARM, "pid", {"wc": 1.5, "pm_deg": 50, "ti_td": 4.0}),
    (ARM, "lag", {"wc": 0.5, "pm_deg": 40, "dc_gain": 10.0}),
    (ARM, "leadlag", {"wc": 1.5, "pm_deg": 50, "dc_gain": 10.0, "lag_corner": 0.1}),
    (ARM, "leadlag", {"wc": 1.5, "pm_deg": 50, "dc_gain": 10.0, "lag_ratio": 5.0}),
    (zoh.Roots(zeros=[-3.0], poles=[0, -0.7], gain=2.0), "pi", {"wc": 0.3, "pm_deg": 40}),
    (zoh.Geared(joint=JOINT), "pd", {"wc": 1.5, "pm_deg": 50}),
]


@pytest.mark.parametrize(("plant", "law", "given"), COLUMNS)
def test_every_variable_has_a_unit_and_a_long_name(plant, law, given):
    pytest.importorskip("xarray")
    job = Job(plant=plant, law=law, asked=given, dt=0.1)
    over = zoh.Rows(values={k: [job.value(k)] for k in job.keys() if job.value(k) is not None})
    found = zoh.sweep(plant, law, given, over=over, arithmetic="single").dataset
    assert set(given) | {"dt", "dead_time", "ms", "stable", "reason"} <= set(found.variables)
    for name, variable in found.variables.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"] not in ("", name), name


@pytest.mark.parametrize(
    ("plant", "units"),
    [
        # G has the unit output/input, s that of 1/s, and den[0] none
        (zoh.Plant(num=[2.0, 3.0], den=[1.5, 0.7, 0.2, 0]),
         {"gain": "output/input/s^2", "num.0": "output/input/s^2", "num.1": "output/input/s^3",
          "den.0": "1", "den.1": "1/s", "den.3": "1/s^3"}),
        (zoh.Plant(num=[2.0, 3.0], den=[1.0, 0.5]),
         {"gain": "output/input", "num.0": "output/input", "num.1": "output/input/s"}),
        (zoh.Roots(zeros=[-3.0], poles=[0, -0.7], gain=2.0),
         {"gain": "output/input/s", "zero.0": "rad/s", "pole.1": "rad/s"}),
        (zoh.Geared(joint=JOINT), {"joint.back_emf": "V s/rad", "joint.load_inertia": "kg m^2"}),
    ],
)  # fmt: skip
def test_units_of_a_plant_s_numbers_by_hand(plant, units):
    assert {key: unit_and_name(f"plant.{key}", plant)[0] for key in units} == units


def test_a_sample_has_one_axis():
    pytest.importorskip("xarray")
    spreads = {"plant.gain": zoh.Normal(mean=2.3, sd=0.1)}
    found = zoh.sweep(
        ARM, "pd", {"wc": 2.0, "pm_deg": 50}, dt=0.1, over=zoh.Random(spreads=spreads, count=5)
    )
    assert found.dataset["ms"].dims == ("loop",)
    assert found.dataset["plant.gain"].dims == ("loop",)


def test_a_controller_that_is_given_stays_as_it_is_at_another_sample_time():
    d = zoh.pd(ARM, dt=0.1, wc=2.0, pm_deg=60)
    found = zoh.sweep(ARM, "given", controller=d.controller, over={"dt": [0.1, 0.05]})
    again = zoh.Sampled(num=d.controller.num, den=d.controller.den, dt=0.05)
    assert found["ms"].tolist() == [d.margins.ms, zoh.verify(ARM, again).margins.ms]


def test_a_file_says_the_controller_and_the_sections(tmp_path):
    xarray = pytest.importorskip("xarray")
    controller = zoh.Sampled(num=[3.0, -2.9], den=[1, -0.9], dt=0.1)
    given = zoh.sweep(ARM, "given", controller=controller, over={"plant.gain": [2.0, 2.3]})
    given.to_netcdf(str(tmp_path / "a.nc"))
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as opened:
        about = opened.attrs
    assert json.loads(about["controller"]) == {"num": [3.0, -2.9], "den": [1.0, -0.9], "dt": 0.1}
    assert json.loads(about["sections"]) == []
    notch = zoh.notch(w0=9)
    designed = zoh.sweep(
        ARM, "pd", {"wc": 2.0, "pm_deg": 50}, dt=0.1, over={"plant.gain": [2.3]}, sections=[notch]
    )
    about = designed.dataset.attrs
    assert json.loads(about["controller"]) is None
    assert [zoh.SecondOrder(**each) for each in json.loads(about["sections"])] == [notch]


def test_a_sample_time_that_varies_is_each_row_s_own():
    """The first row is no worse than the others, and none decides for another."""
    dts = [-0.1, 0.0, 0.1, 0.05, 1e9]
    found = zoh.sweep(ARM, "pd", {"wc": 2.0, "pm_deg": 60}, over={"dt": dts})
    reasons = [zoh.Reason(code).name for code in found["reason"]]
    assert reasons == ["MALFORMED", "MALFORMED", "OK", "OK", "BEYOND_NYQUIST"]
    for i in (2, 3):
        assert found["ms"][i] == zoh.pd(ARM, dt=dts[i], wc=2.0, pm_deg=60).margins.ms
    backwards = zoh.sweep(ARM, "pd", {"wc": 2.0, "pm_deg": 60}, over={"dt": dts[::-1]})
    assert found["ms"].tolist()[2:4] == backwards["ms"].tolist()[1:3][::-1]
    d = zoh.pd(ARM, dt=0.1, wc=2.0, pm_deg=60)
    given = zoh.sweep(ARM, "given", controller=d.controller, over={"dt": [-1.0, 0.1]})
    assert given["reason"].tolist() == [zoh.Reason.MALFORMED, zoh.Reason.OK]


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"over": {"wx": [1.0]}}, "over"),
        ({"over": [1.0]}, "over"),
        ({"dt": None}, "dt"),
        ({"arithmetic": "abacus"}, "arithmetic"),
        ({"over": zoh.Random(spreads={"wc": zoh.Uniform(low=1, high=2)}, count=10**9)}, "over"),
        ({"requirements": zoh.Requirements(noise_gain=1.0)}, "requirements.noise_gain"),
        ({"plant": 1.0}, "plant"),
        ({"sections": [3]}, "sections[0]"),
        ({"sections": zoh.notch(w0=9.0)}, "sections"),
        ({"client": "tcp://127.0.0.1:8786"}, "client"),
    ],
)
def test_a_malformed_sweep_is_refused_in_one_line(changes, argument):
    asked = {"plant": ARM, "law": "pi", "given": {"pm_deg": 40}, "dt": 0.1, "over": {"wc": [0.5]}}
    with pytest.raises(zoh.SpecError) as refused:
        zoh.sweep(**{**asked, **changes})
    assert refused.value.argument == argument
    assert "\n" not in str(refused.value)


def test_a_bound_on_the_bandwidth_is_that_of_the_single_design():
    held = zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [0.4, 0.8]})
    one = zoh.pi(ARM, dt=0.1, wc=0.4, pm_deg=40).margins.bandwidth
    assert held["bandwidth"][0] == pytest.approx(one, rel=1e-12)
    assert held.yield_(zoh.Requirements(bandwidth=one * (1 + 1e-6))) == 0.5
    assert held.yield_(zoh.Requirements(bandwidth=one)) == 1.0


def test_some_of_the_loops_by_number_or_by_mask(swept):
    good = swept["ms"] < 1.4
    assert 0 < good.sum() < len(swept)
    by_mask = swept.take(good)
    assert by_mask["wc"].tolist() == swept["wc"][good].tolist()
    assert swept.take(np.flatnonzero(good))["ms"].tolist() == by_mask["ms"].tolist()
    assert swept.take([-1, 0])["wc"].tolist() == [swept["wc"][-1], swept["wc"][0]]
    for wrong in ([], 0, [0.5, 1.5], [18], [-19], [True, False], [[0, 1]]):
        with pytest.raises(zoh.SpecError, match="loops must be numbers of some of the 18 loops"):
            swept.take(wrong)
    with pytest.raises(zoh.SpecError, match="this mask selects nothing") as refused:
        swept.take(swept["ms"] < 0)
    assert "\n" not in str(refused.value)


def test_no_front_where_no_loop_is_good():
    none = zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [5.0, 6.0]})
    with pytest.raises(zoh.SpecError, match="names must be figures of a loop that keeps"):
        none.pareto("ms")


@pytest.mark.parametrize("wrong", [{"ms": 1.5}, 3, "ms < 2"])
def test_requirements_that_are_none(swept, wrong):
    with pytest.raises(zoh.SpecError, match="requirements must be zoh"):
        swept.yield_(wrong)
    with pytest.raises(zoh.SpecError, match="requirements must be zoh"):
        zoh.sweep(ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [0.5]}, requirements=wrong)


@pytest.mark.parametrize("wrong", [2.5, 0, "a"])
def test_a_block_is_a_whole_number_of_loops(wrong):
    job = zoh.Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    with pytest.raises(zoh.SpecError, match="block must be"):
        zoh.sweep_summary(job, {"wc": [0.5]}, block=wrong)

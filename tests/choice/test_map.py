"""A map says of every point what a design made there says of itself."""

import numpy as np
import pytest

import zoh
from zoh.report.canvas import render
from zoh.report.map import law_figure

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
ASKED = zoh.Requirements(pm_deg=45, ms=1.7, gain_margin_db=10, overshoot_pct=20)
GIVEN = [("pd", {}), ("pi", {}), ("pid", {"ki": 0.85}), ("lead", {"dc_gain": 10.0})]


@pytest.mark.parametrize(("law", "given"), GIVEN, ids=[law for law, _ in GIVEN])
def test_a_point_is_the_design_made_there(law, given):
    found = zoh.law_map(ARM, law, dt=0.1, requirements=ASKED, given=given, points=(9, 7))
    seen = set()
    for (i, j), slack in np.ndenumerate(found.slack):
        if np.isnan(slack):
            assert np.isnan(found.pm_deg[i, j])
            continue
        wc, pm_deg = float(found.wc[j]), float(found.pm_deg[i, j])
        try:
            d = zoh.design(ARM, law, {**given, "wc": wc, "pm_deg": pm_deg}, dt=0.1)
        except zoh.NotMet:
            seen.add("no loop")
            assert slack == -np.inf
            continue
        seen.add(bool(slack >= 0))
        between = d.step.between_samples.overshoot_pct
        values = (d.margins.phase_margin_deg, d.margins.gain_margin_db, d.margins.ms, between)
        names = ("pm_deg", "gain_margin_db", "ms", "overshoot_pct")
        for name, value in zip(names, values, strict=True):
            shown = found.values[name][i, j]
            assert shown == pytest.approx(abs(value) if "gain" in name else value, rel=1e-9)
        by_hand = min(
            values[0] / 45 - 1, abs(values[1]) / 10 - 1, 1 - values[2] / 1.7, 1 - between / 20
        )
        assert max(by_hand, 0.0) == pytest.approx(max(slack, 0.0), abs=1e-9)
    assert {True, False} <= seen


def test_the_margins_span_what_the_law_can_give():
    found = zoh.law_map(ARM, "pd", dt=0.1, points=(9, 5))
    assert found.requirements == zoh.Requirements(pm_deg=45, ms=1.7)
    for j, wc in enumerate(found.wc.tolist()):
        if np.isfinite(found.pm_deg[0, j]):
            low, high = found.pm_deg[[0, -1], j].tolist()
            for outside in (low - 0.5, high + 12.0):  # 12 deg: a slow zero is left out before
                if 1 < outside < 179:
                    with pytest.raises((zoh.Infeasible, zoh.NotMet)):
                        zoh.pd(ARM, dt=0.1, wc=wc, pm_deg=outside)


def test_as_data_and_as_a_figure():
    found = zoh.law_map(ARM, "pd", dt=0.1, requirements=ASKED, points=(8, 6))
    data = found.to_dict()
    assert (len(data["wc"]), len(data["pm_deg"]), len(data["slack"][0])) == (8, 6, 8)
    assert data["slack"][0][-1] is None
    chosen = (5.0, 60.0)
    one, two = (render(law_figure(found, chosen=chosen)) for _ in range(2))
    assert one == two  # the same bytes again
    for text in ("meets everything", "ms = 1.7", "chosen"):
        assert text in {
            t.get_text() for t in law_figure(found, chosen=chosen).axes[0].get_legend().get_texts()
        }


def test_what_has_no_map_is_refused():
    with pytest.raises(zoh.SpecError, match="law must be one of pi, pd, pid, lead, lag"):
        zoh.law_map(ARM, "p", dt=0.1)
    with pytest.raises(zoh.SpecError, match="ki is no parameter of pi"):
        zoh.law_map(ARM, "pi", dt=0.1, given={"ki": 1.0})
    with pytest.raises(zoh.SpecError, match="points must be a whole number of 2 or more"):
        zoh.law_map(ARM, "pi", dt=0.1, points=(1, 4))


def test_a_map_knows_setpoint_weights_and_negative_gains():
    asked = zoh.Requirements(overshoot_pct=2.0, ms=1.7)
    given = {"setpoint_weight": 0.0}
    weighted = zoh.law_map(ARM, "pi", dt=0.1, requirements=asked, given=given, points=(9, 7))
    plain = zoh.law_map(ARM, "pi", dt=0.1, requirements=asked, points=(9, 7))
    assert weighted.met.any()
    assert not plain.met.any()
    opposite = zoh.Plant(num=[-2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    turned = zoh.law_map(
        opposite, "pi", dt=0.1, requirements=asked, given=given, points=(9, 7),
        allow=["negative_gains"],
    )  # fmt: skip
    np.testing.assert_array_equal(turned.met, weighted.met)
    for name in ("wc", "pm_deg"):
        with pytest.raises(zoh.SpecError, match="is no parameter of a map of pi"):
            zoh.law_map(ARM, "pi", dt=0.1, given={name: 1.0})
    with pytest.raises(zoh.SpecError, match="ti_td must not be given beside ki"):
        zoh.law_map(ARM, "pid", dt=0.1, given={"ki": 1.0, "ti_td": 4.0})

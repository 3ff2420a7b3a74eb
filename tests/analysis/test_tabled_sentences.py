"""What a table says of itself, to the word, and what a loop on it verifies, to the figure.

Every loop here is a power of w or a constant, which the curve between the points meets exactly, so
each figure in a sentence follows by hand; the hand is in the comment beside it.
"""

from math import degrees, inf, log, pi, sqrt

import pytest

import zoh
from zoh import FrequencyResponse, Requirements, Sampled
from zoh.analysis.squares import DROP
from zoh.analysis.tabled.results import Spread
from zoh.analysis.tabled.verify import (
    TableMeasured,
    TableVerified,
    in_clock,
    measure_table,
    table_missed,
    table_verified,
    verify_table,
)
from zoh.analysis.tabled.words import _amounts, _db
from zoh.errors import NotMet, SpecError

NO_MORE = "; no resonance hides between the points"
DECIDED = "stability is counted on the table; taken for granted: the plant has "
OPEN = "the table does not decide stability: "
SHORT = "the table is too short to tell what lies between its points"
ONE = Sampled(num=[1.0], den=[1.0], dt=0.1)


def powers(w, k=1.0, slope=-1, phase=-90.0, **more):
    """Return k w^slope at a phase that stays the same."""
    magnitude = [k * x**slope for x in w]
    return FrequencyResponse(w=w, magnitude=magnitude, phase_deg=[phase] * len(w), **more)


def integrator(**more):
    """1/(j w) at five points from 0.5 to 8 rad/s."""
    return powers([0.5, 1, 2, 4, 8], **more)


LAG = [0.01, 0.1, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 10, 30, 100]
SAID = [
    (  # |1 + L|^2 = 1 + 1/64 at 8 rad/s, Ms^2 |L| e = (64/65)/8 * 0.01; PM is off by e itself
        integrator(uncertainty=0.01),
        f"{DECIDED}no unstable poles{NO_MORE}; below 0.5 rad/s its gain falls with w^-1, as its "
        "low end does; beyond 8 rad/s its gain rises no more (then |L| stays below 0.125)",
        # 20 log10 8, and 1/(1 - 1/8)
        "crossings below 0.5 and above 8 rad/s are not seen; granted the same, none has a gain "
        "margin nearer to 0 than 18.06 dB, and Ms is at most 1.143 there",
        "no phase crossing in the table: the gain margin given, 18.06 dB, is a bound",
        "between its points the table is joined by a curve; without every second point PM, GM "
        "and Ms would move by 0 deg, none, 0: a resonance narrower than the spacing is not seen "
        "at all",
        "1 sigma of the points is, to first order, 1 sigma of PM, GM and Ms: 0.57 deg, none, "
        "0.0012",
    ),
    (  # the same, a bound instead of 1 sigma
        powers([0.5, 1, 2], neglected=0.01),
        f"{DECIDED}no unstable poles{NO_MORE}; below 0.5 rad/s its gain falls with w^-1, as its "
        "low end does; beyond 2 rad/s its gain rises no more (then |L| stays below 0.5)",
        "crossings below 0.5 and above 2 rad/s are not seen; granted the same, none has a gain "
        "margin nearer to 0 than 6.021 dB, and Ms is at most 2 there",
        "no phase crossing in the table: the gain margin given, 6.021 dB, is a bound",
        # (4/5)(1/2) * 0.01
        "what the values leave out moves PM, GM and Ms, to first order, by at most 0.57 deg, "
        "none, 0.004",
        SHORT,
    ),
    (  # -3 all along: it turns around -1 once, as one unstable pole needs
        powers([1, 2, 4], k=3.0, slope=0, phase=-180.0, unstable_poles=1, dt=pi / 4),
        f"{OPEN}it begins at 1 rad/s so near to -180 deg with |L| above 1 that the side cannot be "
        "told: measure further up or down",
        # below the table it is -3 too: 20 log10 of 1/3, |1 + L| = 2
        "crossings below 1 rad/s are not seen; granted the same, none has a gain margin nearer to "
        "0 than -9.542 dB, and Ms is at most 1 there",
        "no gain crossing in the table: a phase margin is not known",
        SHORT,
    ),
    (  # it rises from below, which no integrator explains, and is quiet: it leaves -1 alone
        powers([1, 2, 4], k=0.1, slope=0.5, phase=0.0, unstable_poles=2),
        f"{DECIDED}2 unstable poles{NO_MORE}; beyond 4 rad/s its gain rises no more (then |L| "
        "stays below 0.2)",
    ),
    (  # 2/(s - 1), from -2 at w = 0 through -1 - j to 0: half a turn, for a pole it was not told
        FrequencyResponse.from_complex(w=LAG, gain=[2 / (1j * x - 1) for x in LAG]),
        f"{OPEN}it turns around -1 as only a loop with 1 more unstable poles does than the 0 given",
    ),
    (
        powers([1, 2, 4], k=8.0),
        f"{OPEN}|L| may be as large as 2 beyond 4 rad/s, where the table ends: measure further, "
        "until it stays below 1",
        "crossings below 1 and above 4 rad/s are not seen, and nothing bounds what is there",
        "no gain crossing in the table: a phase margin is not known",
        "no phase crossing in the table: the gain margin given, 0 dB, is a bound",
        SHORT,
    ),
    (
        powers([1, 2, 4], k=2.0, slope=-1.5, phase=-90.0),
        f"{OPEN}below 1 rad/s, where the table begins, neither slope nor phase show how it goes "
        "on: measure further down, until they settle",
        "crossings below 1 and above 4 rad/s are not seen, and nothing bounds what is there",
        "no phase crossing in the table: the gain margin given, 0 dB, is a bound",
        SHORT,
        "the low end does not say |T| at 0: the bandwidth is counted from it at 1 rad/s",
    ),
    (
        powers([1, 2, 4], k=0.9, phase=-180.0, slope=0, uncertainty=0.05),
        f"{OPEN}within its uncertainty (3 sigma) the loop may be -1 at 1 rad/s",
    ),
    (
        FrequencyResponse(w=[1, 2, 4], magnitude=[4, 2, 0.4], phase_deg=[-90, -90, -250]),
        f"{OPEN}from 2 to 4 rad/s the phase turns by 160 deg, where |L| is above 0.5: it may have "
        "turned the other way; measure more points there",
    ),
]


@pytest.mark.parametrize("said", SAID, ids=lambda said: said[1][:60])
def test_what_a_table_says_of_itself(said):
    loop, *sentences = said
    found = zoh.margins(loop).warnings
    assert list(found[: len(sentences)]) == sentences
    if len(sentences) > 1:
        assert len(found) == len(sentences)


@pytest.mark.parametrize(
    ("count", "places"),
    [
        (1, "1 to 2 rad/s"),
        (3, "1 to 2, 2 to 3, 3 to 4 rad/s"),
        (4, "1 to 2, 2 to 3, 3 to 4 and 1 more rad/s"),
        (5, "1 to 2, 2 to 3, 3 to 4 and 2 more rad/s"),
    ],
)
def test_turns_that_may_have_gone_the_other_way_are_named(count, places):
    w = [float(i) for i in range(1, count + 2)]
    phase = [150.0 * (i % 2) for i in range(count + 1)]
    m = zoh.margins(FrequencyResponse(w=w, magnitude=[0.1] * len(w), phase_deg=phase))
    assert m.warnings[-1] == (
        f"the phase turns by more than 120 deg from one point to the next ({places}): it is taken "
        "the shorter way round, and may have gone the other"
    )


def test_a_figure_that_a_shorter_table_loses_is_off_by_an_unknown_amount():
    # |L| is 1.1 at 2 and at 4 rad/s and 0.9 between: without that point it never crosses 1
    loop = FrequencyResponse(
        w=[1, 2, 3, 4, 5], magnitude=[1.1, 1.1, 0.9, 1.1, 1.1], phase_deg=[-90] * 5
    )
    assert "would move by an unknown amount, none, " in zoh.margins(loop).warnings[3]


def test_amounts_in_words():
    known = Spread(phase_margin_deg=1.234, gain_margin_db=0.5678, ms=0.0123)
    assert _amounts(known) == "1.2 deg, 0.57 dB, 0.012"
    unknown = Spread(phase_margin_deg=None, gain_margin_db=inf, ms=0.0)
    assert _amounts(unknown) == "none, an unknown amount, 0"
    assert [_db(x) for x in (2.0, 0.5, inf, 0.0)] == ["6.021 dB", "-6.021 dB", "inf", "0"]


def test_one_unstable_pole_is_one():
    gain = [2 / (1j * x - 1) for x in LAG]
    loop = FrequencyResponse.from_complex(w=LAG, gain=gain, unstable_poles=1)
    assert zoh.margins(loop).warnings[0] == (
        f"{DECIDED}1 unstable pole{NO_MORE}; below 0.01 rad/s its gain is constant, as its low end "
        "does; beyond 100 rad/s its gain rises no more (then |L| stays below 0.02)"
    )


def test_the_margins_of_an_integrator_to_the_last_bit():
    m = zoh.margins(integrator())
    exact = {"rel": 1e-14}
    assert m.stable is True
    assert (m.crossover, m.phase_crossover) == (1.0, None)
    assert m.phase_margin_deg == pytest.approx(90.0, **exact)
    assert m.delay_margin == pytest.approx(pi / 2, **exact)
    assert m.gain_margin == 8.0
    assert m.modulus_margin == pytest.approx(sqrt(1 + 1 / 64), **exact)
    assert m.ms_frequency == pytest.approx(8.0, rel=1e-7)  # the section ends within 1e-8
    assert m.mt == pytest.approx(1 / sqrt(1.25), **exact)
    assert m.mt_frequency == 0.5
    assert m.disk_margin == pytest.approx(2.0, **exact)  # |1 + L| = |1 - L|
    # |T|^2 = 1/(1 + w^2), 1 at w = 0 because the table begins as an integrator does
    assert m.bandwidth == pytest.approx(sqrt(1 / DROP - 1), **exact)
    assert m.band == (0.5, 8.0)
    assert (m.interpolation.phase_margin_deg, m.interpolation.ms) == (0.0, 0.0)
    assert m.beyond.gain_margin == 8.0
    assert m.beyond.phase_margin_deg == inf
    assert m.beyond.ms == pytest.approx(8 / 7, **exact)
    assert m.beyond.mt == pytest.approx(1 / sqrt(1 + (1e-4 * 0.5) ** 2), **exact)  # far below


def test_the_json_form_to_the_key():
    out = zoh.margins(integrator(uncertainty=0.01)).to_dict()
    assert out["band"] == [0.5, 8.0]
    assert out["beyond"] == {
        "gain_margin": 8.0,
        "phase_margin_deg": "inf",
        "ms": pytest.approx(8 / 7),
        "mt": pytest.approx(1.0, rel=2e-9),  # 1 - (5e-5)^2/2
    }
    assert out["noise"] == {
        "phase_margin_deg": pytest.approx(degrees(0.01)),
        "gain_margin_db": None,
        "ms": pytest.approx(0.01 * 8 / 65),
    }
    assert out["interpolation"] == {"phase_margin_deg": 0.0, "gain_margin_db": None, "ms": 0.0}
    assert out["neglected"] is None
    assert out["warnings"] == list(zoh.margins(integrator(uncertainty=0.01)).warnings)
    bound = zoh.margins(integrator(neglected=0.01)).to_dict()
    assert (bound["neglected"], bound["noise"]) == (out["noise"], None)
    known = Spread(phase_margin_deg=inf, gain_margin_db=0.5, ms=0.25).to_dict()
    assert known == {"phase_margin_deg": "inf", "gain_margin_db": 0.5, "ms": 0.25}


# Evidence ------------------------------------------------------------------------------------


def measured(asked=None, law=ONE, plant=None, **more):
    plant = integrator(dt=0.1) if plant is None else plant
    return measure_table(plant, law, requirements=asked, **more)


def test_a_report_to_the_line():
    found = measure_table(
        integrator(dt=0.1), ONE, requirements=Requirements(pm_deg=95), law="PI", name="slow",
        gains={"kp": 1.0, "ki": 0.5},
    )  # fmt: skip
    head = found.report().splitlines()
    assert head[:7] == [
        "slow: PI with kp = 1, ki = 0.5",
        "  standard form: kp = 1, ti = 2",
        "  series form: k = 1, ti = 2",
        "  D(z) = 1, dt = 0.1 s",
        "  closed loop stable",
        "  phase margin 90 deg at 1 rad/s, gain margin 18.06 dB at no rad/s",
        # pi/2 s; Ms = 1/sqrt(1 + 1/64), Mt = 1/sqrt(1.25)
        "  delay margin 1.571 s, Ms 0.9923, Mt 0.8944 in the table",
    ]
    assert head[7:-1] == [f"  note: {sentence}" for sentence in found.margins.warnings]
    assert head[-1] == f"  MISSED: {found.misses[0]}"
    assert len(found.misses) == 1
    plain = measured(law=Sampled(num=[9.0], den=[1.0], dt=0.1)).report().splitlines()
    assert plain[0] == "given: given"
    assert plain[2] == "  closed loop NOT DECIDED by the table"
    around = powers([0.5, 1, 2, 4], slope=-2, phase=-200.0, dt=0.1)
    assert "  closed loop UNSTABLE" in measured(plant=around).report().splitlines()


def test_the_json_form_of_evidence():
    found = measured(name="one", law=ONE, gains={"kp": 1.0})
    out = found.to_dict()
    assert out.pop("margins") == found.margins.to_dict()
    assert out == {
        "name": "one",
        "law": "given",
        "feasible": True,
        "reason": None,
        "gains": {"kp": 1.0},
        "controller": {"num": [1.0], "den": [1.0], "dt": 0.1, "num_w": [1.0], "den_w": [1.0]},
        "step": None,
        "met": True,
        "misses": [],
        "forms": {
            "parallel": {"kp": 1.0},
            "standard": {"kp": 1.0},
            "series": {"k": 1.0},
            "refused": {},
        },
    }


def test_evidence_is_what_was_given():
    plant, asked = powers([0.5, 1, 2, 4, 8]), Requirements(pm_deg=30)
    found = measure_table(plant, ONE, compute_delay=0.05, requirements=asked, gains={"kp": 1.0})
    assert (found.plant, found.controller, found.requirements) == (plant, ONE, asked)
    assert (found.compute_delay, found.dt, found.law, found.name) == (0.05, 0.1, "given", "given")
    assert found.loop.controller is found.controller
    assert found.sampled.w == pytest.approx(zoh.sample(plant, 0.1, 0.05).w)
    assert found.sampled.at(1.0) == zoh.sample(plant, 0.1, 0.05).at(1.0)
    shown = verify_table(plant, ONE, compute_delay=0.05, requirements=asked, gains={"kp": 1.0},
                         law="P", name="mine")  # fmt: skip
    assert isinstance(shown, TableVerified)
    assert (shown.law, shown.name, dict(shown.gains)) == ("P", "mine", {"kp": 1.0})
    assert (shown.compute_delay, shown.requirements) == (0.05, asked)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (
            lambda: measure_table(3, ONE),
            "plant must be a zoh.FrequencyResponse, got 3: zoh.measure has models",
        ),
        (
            lambda: measure_table(integrator(dt=0.1), 3),
            "controller must be a zoh.Sampled, got 3: give num, den and dt",
        ),
        (
            lambda: measured({"pm_deg": 30}),
            "requirements must be zoh.Requirements, got {'pm_deg': 30}: Requirements(ms=1.8)",
        ),
        (
            lambda: in_clock(integrator(), 0.1, -0.5),
            "compute_delay must be 0 or more, got -0.5: give seconds, 0 or more",
        ),
        (
            lambda: in_clock(integrator(dt=0.1), 0.1, -0.5),
            "compute_delay must be 0 or more, got -0.5: give seconds, 0 or more",
        ),
        (
            lambda: in_clock(integrator(dt=0.1), 0.2, 0.0),
            "dt must be the table's 0.1 s, got 0.2: it was measured so",
        ),
        (
            lambda: in_clock(integrator(dt=0.1), 0.1, 0.5),
            "compute_delay must be 0: a sampled table has its delay, got 0.5: leave it out",
        ),
    ],
)
def test_what_cannot_be_measured_is_refused(call, text):
    with pytest.raises(SpecError) as refused:
        call()
    assert str(refused.value) == text


NEVER = " is asked, and a table of margins does not show it"
OUTSIDE = ", which the table meets; outside its band no more than {} is known"


@pytest.mark.parametrize(
    ("asked", "misses"),
    [
        ({}, []),
        # the bounds are 20 log10 8 = 18.06 dB, no margin in phase, Ms 8/7 and Mt 1
        ({"gain_margin_db": 18.0, "pm_deg": 80, "ms": 1.15, "mt": 1.01}, []),
        (
            {"ms": 1.1},
            ["ms must be at most 1.1" + OUTSIDE.format("1.143")],
        ),
        ({"mt": 0.9}, ["mt must be at most 0.9" + OUTSIDE.format("1")]),
        (
            {"overshoot_pct": 5, "rise_time": 1, "settling_time": 1, "steady_state_error": 0.1,
             "peak_effort": 2},
            [n + NEVER for n in ("overshoot_pct", "rise_time", "settling_time",
                                 "steady_state_error", "peak_effort")],
        ),
    ],
)  # fmt: skip
def test_what_is_asked_of_a_table_and_what_it_does_not_show(asked, misses):
    assert table_missed(Requirements(**asked), zoh.margins(integrator())) == misses


def test_bounds_outside_the_band_count_where_they_are_lower():
    # the crossing at 2 rad/s shows 20 dB; |L| is 0.5 where the table ends, 20 log10 2 beyond
    loop = FrequencyResponse(
        w=[0.25, 0.5, 1, 2, 4, 8],
        magnitude=[4, 2, 1, 0.1, 0.25, 0.5],
        phase_deg=[-90, -90, -120, -180, -185, -185],
    )
    m = zoh.margins(loop)
    assert m.gain_margin == pytest.approx(10.0, rel=1e-12)
    assert m.beyond.gain_margin == 2.0
    assert table_missed(Requirements(gain_margin_db=6.5), m) == [
        "gain_margin_db must be at least 6.5" + OUTSIDE.format("6.021")
    ]
    assert table_missed(Requirements(gain_margin_db=6.0), m) == []


def test_what_is_missed_is_not_verified():
    with pytest.raises(NotMet) as refused:
        verify_table(integrator(dt=0.1), ONE, requirements=Requirements(pm_deg=95), name="late")
    assert refused.value.measured.name == "late"
    assert refused.value.misses == refused.value.measured.misses
    assert len(refused.value.misses) == 1
    assert refused.value.misses[0].startswith("pm_deg must be at least 95")


def fields(evidence, **changed):
    kept = {f: getattr(evidence, f) for f in type(evidence).__dataclass_fields__}
    return kept | changed


def test_evidence_of_another_loop_verifies_nothing():
    good = measured()
    assert TableVerified(**fields(good)).met
    for changed in (
        {"controller": Sampled(num=[1.01], den=[1.0], dt=0.1)},  # crosses elsewhere
        {"controller": Sampled(num=[9.0], den=[1.0], dt=0.1)},  # is not decided
        {"margins": measured(law=Sampled(num=[0.9], den=[1.0], dt=0.1)).margins},
    ):
        with pytest.raises(NotMet) as refused:
            TableVerified(**fields(good, **changed))
        assert refused.value.misses == ("the evidence is not this loop's",)
        assert isinstance(refused.value.measured, TableVerified)
    late = measured(plant=powers([0.5, 1, 2, 4, 8]), compute_delay=0.05)
    with pytest.raises(NotMet, match="the evidence is not this loop's"):
        TableVerified(**fields(late, compute_delay=0.5))


def test_a_miss_said_by_hand_is_a_miss():
    with pytest.raises(NotMet) as refused:
        TableVerified(**fields(measured(), misses=("by hand",)))
    assert refused.value.misses == ("by hand",)
    with pytest.raises(NotMet) as refused:
        table_verified(measured(Requirements(pm_deg=95)))
    assert refused.value.misses[0].startswith("pm_deg must be at least 95")


def test_a_bound_outside_that_is_just_met_is_met():
    m = zoh.margins(integrator())
    assert table_missed(Requirements(ms=m.beyond.ms), m) == []
    assert table_missed(Requirements(gain_margin_db=20 * log(8) / log(10)), m) == []


def test_a_report_of_a_law_with_poles_and_of_a_phase_crossing():
    law = Sampled(num=[2.0], den=[1.0, -0.5], dt=0.1)
    lines = measured(law=law).report().splitlines()
    assert lines[1] == "  D(z) = 2/(z - 0.5), dt = 0.1 s"
    # w^-2 at -135 deg - 30 ln w: 45 deg at 1 rad/s; -180 deg at e^1.5 = 4.48169, of factor e^3
    w = [0.25, 1.5, 3, 5, 9, 27]
    phase = [-135 - 30 * log(x) for x in w]
    loop = FrequencyResponse(w=w, magnitude=[x**-2 for x in w], phase_deg=phase, dt=0.1)
    assert measured(plant=loop).report().splitlines()[3] == (
        "  phase margin 45 deg at 1 rad/s, gain margin 26.06 dB at 4.48169 rad/s"
    )


def test_what_is_not_said_of_evidence():
    good = fields(measured())
    del good["misses"]
    assert TableMeasured(**good).misses == ()
    assert verify_table(integrator(dt=0.1), ONE).law == "given"

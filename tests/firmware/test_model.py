"""The step against laws worked out by hand, in fractions and in 50 digits; its features one by one.

Numbers are chosen so that floats hold them exactly, so that equality is meant where it is written.
"""

from fractions import Fraction as F
from math import inf, isnan, nan

import mpmath
import pytest
from designs import LAWS, design, made
from hypothesis import given, settings
from hypothesis import strategies as st

import zoh
from zoh.firmware.levels import levelled
from zoh.firmware.linear import transfer
from zoh.firmware.model import Model
from zoh.firmware.plan import plan
from zoh.firmware.realise import from_d, parallel, sections
from zoh.firmware.vectors import chance, hostile
from zoh.lti.systems import Sampled

# 1/(s + 1) is stable under all of these; the controllers' coefficients are short in binary
PLANT = zoh.Plant(num=[1.0], den=[1.0, 1.0])


def simple(num, den, number="f64", **options):
    given = zoh.verify(PLANT, Sampled(num=num, den=den, dt=0.25))
    return Model(plan(given, number=number, **options))


def recursion(controller, errors):
    """Return u of the z-coefficients in 50 digits: den(z) u = num(z) e."""
    with mpmath.workdps(50):
        num = [mpmath.mpf(0)] * (len(controller.den) - len(controller.num)) + [
            mpmath.mpf(c) for c in controller.num
        ]
        den, out = [mpmath.mpf(c) for c in controller.den], []
        for k in range(len(errors)):
            total = mpmath.mpf(0)
            for i in range(len(den)):
                if k >= i:
                    total += num[i] * errors[k - i]
                    total -= den[i] * out[k - i] if i else 0
            out.append(total / den[0])
        return [float(u) for u in out]


# of the largest u: the coefficients of z are rounded to 53 bits, the model's to 53 or 24
@pytest.mark.parametrize(("number", "tolerance"), [("f64", 1e-12), ("f32", 2e-4)])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("realisation", ["auto", "cascade", "delta"])
def test_without_limits_it_is_the_difference_equation(law, number, tolerance, realisation):
    model = Model(plan(design(law), number=number, realisation=realisation))
    numbers = chance(3)
    inputs = [(next(numbers) % 1024 / 512 - 1, next(numbers) % 1024 / 512 - 1) for _ in range(60)]
    truth = recursion(design(law).controller, [r - y for r, y in inputs])
    found = [float(model.step(r, y)) for r, y in inputs]
    size = max(map(abs, truth))
    assert max(abs(a - b) for a, b in zip(found, truth, strict=True)) < tolerance * size


def allowed(made_):
    """Return what rounding may do to u in steps, over 40 samples.

    u is rounded to half a step, a filter's output to one, times its gain; the output of a section
    before the last one to a step, which the last one answers.
    """
    if made_.realisation == "pid":
        total = 0.55  # 0.05 for what the integral's bits below the sums' add up to
        for part in parallel(made_.design.controller).filters:
            if part.alpha != 1:  # half the sum of the sizes of 1, -alpha, -alpha (1 - alpha), ...
                total += abs(part.kd) * (1 + part.alpha / (1 - abs(1 - part.alpha))) / 2
        return total
    parts = levelled(sections(made_.design.controller))
    if len(parts) == 1:
        return 1.05
    last = from_d(parts[-1].b, (F(1), *parts[-1].a), made_.dt)
    return 1.05 + 1.05 * sum(map(abs, recursion(last, [1] + [0] * 39)))


@pytest.mark.parametrize("number", ["q15", "q31"])
@pytest.mark.parametrize(
    ("law", "realisation"),
    [(law, "auto") for law in LAWS if law != "notched"]
    + [(law, "cascade") for law in ("pi", "pid", "notched")],
)
def test_in_whole_numbers_it_is_the_quantised_difference_equation(law, number, realisation):
    made_ = made(law, number, realisation=realisation)
    assert made_.format.gain == 1
    model, top = Model(made_), 1 << (7 if number == "q15" else 23)
    numbers = chance(5)
    inputs = [(next(numbers) % top - top // 2, next(numbers) % top // 4) for _ in range(40)]
    truth = recursion(made_.quantised.controller, [r - y for r, y in inputs])
    assert max(map(abs, truth)) < 1 << (15 if number == "q15" else 31)
    found = [model.step(r, y) for r, y in inputs]
    assert max(abs(a - b) for a, b in zip(found, truth, strict=True)) < allowed(made_)
    assert max(map(abs, truth)) > 10 * allowed(made_)


def test_pi_by_hand():
    # kp + ki/(z-1) with kp = 2, ki = 1/2: x collects e/2
    model = simple([2.0, -1.5], [1.0, -1.0])
    assert [model.step(1.0, 0.0) for _ in range(3)] == [2.0, 2.5, 3.0]
    assert model.step(0.0, 1.0) == -2.0 + 1.5
    assert model.state["x"] == 1.0


def test_feed_forward_is_added():
    model = simple([2.0], [1.0])
    assert model.step(1.0, 0.5, 0.25) == 1.25


def test_conditional_integration_waits_at_the_limit_and_leaves_it_at_once():
    model = simple([2.0, -1.5], [1.0, -1.0], u_min=-1.0, u_max=3.0)
    assert [model.step(4.0, 0.0) for _ in range(5)] == [3.0] * 5
    assert model.state["x"] == 0.0  # v = 8 was above the limit all the time
    assert model.step(-0.25, 0.0) == -0.5
    assert model.state["x"] == -0.125


def test_it_integrates_at_a_limit_that_it_is_leaving():
    model = simple([2.0, -1.5], [1.0, -1.0], u_min=-1.0, u_max=3.0)
    model.reset(3.0)
    model.step(-0.25, 0.0, 8.0)  # the feed-forward holds it there, the error points away
    assert model.state["x"] == 3.0 - 0.125


def test_back_calculation_by_hand():
    # Ti = kp/ki dt with kp = 2 - ki/2 = 1.75, ki = 0.5: Tt/dt = 3.5
    model = simple([2.0, -1.5], [1.0, -1.0], u_min=-1.0, u_max=3.0, anti_windup="back_calculation")
    back = model.plan.program.value("back")
    assert back == 1 / 3.5
    model.step(4.0, 0.0)
    assert model.state["x"] == 2.0 + back * (3.0 - 8.0)


def test_tracking_takes_the_whole_excess_back():
    model = simple([2.0, -1.5], [1.0, -1.0], u_min=-1.0, u_max=3.0, anti_windup="tracking")
    model.step(4.0, 0.0)
    assert model.state["x"] == 2.0 + (3.0 - 8.0)


def test_sections_are_told_the_limited_output():
    model = simple([2.0, -1.5], [1.0, -1.0], u_max=3.0, realisation="cascade")
    model.step(4.0, 0.0)
    # s1 <- b1 e + u with b1 = -1.5 and u = 3, not 8
    assert model.state["s1_1"] == -1.5 * 4.0 + 3.0


def test_the_rate_is_limited_around_the_last_output():
    model = simple([2.0], [1.0], rate=2.0)  # 0.5 a sample
    assert [model.step(4.0, 0.0) for _ in range(3)] == [0.5, 1.0, 1.5]
    assert model.step(-4.0, 0.0) == 1.0


def test_set_point_weights_by_hand():
    # kp = 2 is 1.75 and half a step of the integral: with b = 0.5 it is 0.875 + 0.25 on r
    model = simple([2.0, -1.5], [1.0, -1.0], setpoint_weight=0.5)
    assert model.step(1.0, 0.0) == 1.125
    assert simple([2.0, -1.5], [1.0, -1.0], setpoint_weight=0.0).step(1.0, 0.0) == 0.25
    assert model.step(0.0, 0.0) == 0.5  # the integral saw all of r


def test_a_derivative_without_the_reference_does_not_kick():
    # 1 + 2 (z-1)/(z - 0.5)
    num, den = [3.0, -2.5], [1.0, -0.5]
    assert simple(num, den).step(1.0, 0.0) == 3.0
    assert simple(num, den, derivative_weight=0.0).step(1.0, 0.0) == 1.0
    assert simple(num, den, derivative_weight=0.5).step(1.0, 0.0) == 2.0
    # of the measurement all of it is there
    assert simple(num, den, derivative_weight=0.0).step(0.0, 1.0) == -3.0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("number", ["f32", "f64", "q31", "q15"])
@pytest.mark.parametrize("realisation", ["auto", "cascade", "delta"])
def test_after_track_the_same_inputs_give_the_manual_output(law, number, realisation):
    try:
        model = Model(made(law, number, realisation=realisation))
    except zoh.SpecError:
        assert (law, number) == ("leadlag", "q15")  # it says what does not fit
        assert realisation != "auto"
        return
    top = 1.0 if number in ("f32", "f64") else 2.0 ** (15 if number == "q15" else 31) / 12
    r, y, ff, u = (int(x * top) if top > 1 else x for x in (0.02, 0.01, -1.0, 3.0))
    for _ in range(3):
        model.track(r, y, ff, u)
    found = float(model.step(r, y, ff))
    if model.plan.realisation == "pid" and "x" not in model.state:
        # a law without an integral has nothing that could hold u: its filters are at rest
        kp = next(c for c in model.plan.coefficients if c.name == "kp")
        u = float(kp.value) / (1 << kp.point) * (r - y) + ff
    # a step of u, or its last bits times what the sums are larger by
    assert abs(found - u) <= {"f64": 1e-12, "f32": 1e-4}.get(number, 1)


@settings(max_examples=300)
@given(
    what=st.sampled_from([
        ("pi", "pid", {}), ("pid_filtered", "pid", {}), ("pid", "cascade", {}),
        ("pid_filtered", "delta", {}), ("notched", "cascade", {}), ("notched", "delta", {}),
        ("pid_filtered", "pid", {"setpoint_weight": 0.3, "derivative_weight": 0.6, "rate": 5.0}),
        ("pid_filtered", "pid", {"anti_windup": "back_calculation"}),
        ("pid", "pid", {"anti_windup": "none"}),
    ]),
    number=st.sampled_from(["q15", "q31"]),
    data=st.data(),
)  # fmt: skip
def test_a_hand_over_in_whole_numbers_is_exact_whatever_the_inputs(what, number, data):
    law, realisation, options = what
    model = Model(made(law, number, realisation=realisation, **options))
    form = model.plan.format
    of_the_format = st.integers(form.least, form.most) | st.sampled_from([form.least, form.most])
    r, y, ff, u = (data.draw(of_the_format) for _ in range(4))
    model.track(r, y, ff, u)
    assert model.step(r, y, ff) == u
    model.track(y, y, ff, u)  # without an error it stays, for there is an integrator
    assert [model.step(y, y, ff) for _ in range(5)] == [u] * 5


@pytest.mark.parametrize(
    ("anti_windup", "number", "apart"),
    # V; in 16 bits gains have 0.1 %, of parts of up to 300 V, and the share that is fed back 0.4 %
    [("conditional", "q15", 0.1), ("tracking", "q15", 0.1), ("back_calculation", "q15", 0.4),
     ("conditional", "q31", 1e-4), ("tracking", "q31", 1e-4), ("back_calculation", "q31", 1e-3)],
)  # fmt: skip
@pytest.mark.parametrize("law", ["pid", "pid_filtered"])
def test_a_limit_does_the_same_in_whole_numbers_as_in_floats(law, anti_windup, number, apart):
    limits = {"u_min": -5.0, "u_max": 12.0, "anti_windup": anti_windup, "realisation": "pid"}
    floats = Model(made(law, "f64", **limits))
    whole = Model(made(law, number, u_range=(-12, 12), **limits))
    step, numbers, r = float(whole.plan.format.y_unit), chance(3), 0
    for k in range(800):
        r = r if k % 20 else (next(numbers) % 9 - 4) * 3000 * (1 if number == "q15" else 1 << 16)
        y = round((next(numbers) / 2**32 - 0.5) * 6 / step)
        r = max(-(1 << 15 if number == "q15" else 1 << 31), r)
        found = int(whole.step(r, y)) * float(whole.plan.format.u_unit)
        assert abs(float(floats.step(r * step, y * step)) - found) < apart, k


@pytest.mark.parametrize("number", ["q31", "q15"])
@pytest.mark.parametrize("realisation", ["pid", "cascade", "delta"])
def test_a_low_gain_holds_an_output_against_all_of_a_feed_forward(realisation, number):
    ends = {"y_range": (-1, 1), "u_range": (-1, 1), "realisation": realisation}
    model = simple([0.125, -0.0625], [1.0, -1.0], number=number, **ends)
    least, most = model.plan.format.least, model.plan.format.most
    for ff, u in ((least, most), (most, least)):
        model.track(0, 0, ff, u)
        assert [model.step(0, 0, ff) for _ in range(5)] == [u] * 5


@pytest.mark.parametrize("number", ["f32", "f64", "q31", "q15"])
@pytest.mark.parametrize(
    ("law", "realisation"),
    [("pi", "pid"), ("pid_filtered", "pid"), ("pid", "cascade"), ("pid", "delta"),
     ("notched", "cascade"), ("notched", "delta"), ("leadlag", "delta")],
)  # fmt: skip
def test_reset_is_rest_at_that_output(law, realisation, number):
    if (law, number) == ("leadlag", "q15"):
        law = "lead"  # 16 bits do not hold the other's sections
    model = Model(made(law, number, realisation=realisation))
    model.step(1, 0)
    for u0 in (3, -5):
        model.reset(u0)
        assert model.step(0, 0) == u0


@pytest.mark.parametrize(
    ("number", "bad"),
    [(n, b) for n in ("f32", "f64") for b in (nan, inf, -inf)] + [("f32", 3e38), ("f64", -1.7e308)],
)
@pytest.mark.parametrize("law", ["pid_filtered", "notched", "leadlag"])
def test_what_is_not_finite_is_not_used(law, number, bad):
    model = Model(made(law, number))
    for k in range(5):
        model.step(0.1 * k, 0.05)
    before, u = dict(model.state), model.state["u"]
    for count, sample in enumerate([(bad, 0.0, 0.0), (0.0, bad, 0.0), (bad, -bad, bad)], 1):
        assert model.step(*sample) == u
        assert model.state == before
        assert model.faults == count
    model.track(nan, 0.0, 0.0, 1.0)
    model.reset(nan)
    assert model.state == before
    assert model.faults == 5
    assert model.step(0.1, 0.05) != u  # and it goes on


def test_the_states_and_the_output_stay_finite_and_within_the_limits():
    for law in LAWS:
        model = Model(made(law, "f32"))
        for sample in hostile(model.plan, 3000, start=11):
            assert -12 <= model.step(*sample) <= 12
            assert not any(isnan(v) for v in model.state.values())
        assert model.faults > 10


def test_limits_are_rounded_inwards():
    model = simple([2.0], [1.0], number="f32", u_min=-0.1, u_max=0.1)
    assert F(float(model.step(9.0, 0.0))) < F(1, 10)  # the nearest float is above 0.1
    assert F(float(model.step(-9.0, 0.0))) > -F(1, 10)


def test_states_are_the_struct_little_endian():
    model = simple([2.0, -1.5], [1.0, -1.0], number="f32")
    model.step(1.0, 0.0)
    model.step(nan, 0.0)
    # x = 0.5, u = 2, one fault
    assert model.state_bytes() == bytes.fromhex("0000003f 00000040 01000000")
    whole = simple([2.0, -1.5], [1.0, -1.0], number="q31", y_range=(-1, 1), u_range=(-1, 1))
    whole.step(1 << 20, 0)
    x = (1 << 19) << next(c.point for c in whole.plan.coefficients if c.name == "ki")
    assert whole.state_bytes() == x.to_bytes(8, "little", signed=True)


@pytest.mark.parametrize("realisation", ["pid", "cascade"])
def test_in_q15_the_smallest_error_is_integrated_without_loss(realisation):
    model = Model(made("pid", "q15", realisation=realisation))
    outputs = [model.step(1, 0) for _ in range(2001)]
    num, den = transfer(model.plan.program)
    ki = float(num[-1] / den[-2])  # as rounded; the binary point of a section's sum holds it to 8 %
    assert ki == pytest.approx(0.085, rel=1e-3 if realisation == "pid" else 0.1)
    assert abs(outputs[-1] - outputs[1] - 1999 * ki) <= 1


@pytest.mark.parametrize("bad", [32768, -32769])
def test_a_number_beyond_the_format_is_refused(bad):
    model = Model(made("pid", "q15"))
    with pytest.raises(zoh.SpecError, match=r"must be within -32768 and 32767.*limit it"):
        model.step(bad, 0)
    with pytest.raises(TypeError):
        model.step(0.5, 0)

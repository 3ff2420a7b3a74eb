"""Every refusal of the ways from s to z and back, word for word."""

from math import pi

import pytest

from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.convert import METHODS, discretise, undiscretise

LAG = Plant(num=[1], den=[1, 1])
PRESERVED = {
    "zoh": "exact at the samples for an input held between them",
    "foh": "exact at the samples for an input in straight lines between them",
    "impulse": "dt times the impulse response at the samples",
    "tustin": "stability, and every gain with the frequency axis warped: w for s",
    "prewarp": "as tustin, with gain and phase exact at the frequency prewarp",
    "matched": "poles and zeros by z = exp(s dt), and the gain at zero frequency",
    "forward": "slow poles nearly (Euler); a stable plant may come out unstable",
    "backward": "slow poles nearly (Euler); a stable plant comes out stable",
}
ON_NEGATIVE_AXIS = (
    "system must have no pole (nor zero, if matched) on the negative real axis for method {!r}, "
    "got [(-0.5+0j)]: no plant has one: use method 'tustin' or 'forward'"
)
IMPROPER = (
    "system must have no pole at z = {} for this method, got {}: its plant would be improper; "
    "use method 'forward', whose inverse always exists"
)
PREWARP = "prewarp must be {}, got {}: {}"
EXACT_THERE = "give the frequency in rad/s that must be exact"

THERE = [
    (
        (LAG, 0.1, "bilinear"),
        "method must be a known method, got 'bilinear': "
        "one of zoh, foh, impulse, tustin, prewarp, matched, forward, backward",
    ),
    ((LAG, 0.1, "prewarp"), PREWARP.format("a real number", None, EXACT_THERE)),
    ((LAG, 0.1, "tustin", -1.0), PREWARP.format("above 0", -1.0, EXACT_THERE)),
    # pi/0.1 = 31.4159, pi/40 = 0.0785398
    (
        (LAG, 0.1, "tustin", 40.0),
        PREWARP.format(
            "below the Nyquist frequency pi/dt = 31.4159 rad/s",
            40.0,
            "lower it, or sample faster than dt = 0.07854 s",
        ),
    ),
    (
        (LAG, 0.1, "zoh", 1.0),
        PREWARP.format(
            "left out unless the method is 'tustin' or 'prewarp'",
            1.0,
            f"method 'zoh' ({METHODS['zoh']}) has no such frequency",
        ),
    ),
    (
        (Plant(num=[1], den=[1, 1], dead_time=0.05), 0.1, "tustin"),
        "dead_time must be a whole number of samples (0.1 s each) for method 'tustin', got 0.05: "
        "use method 'zoh', which is exact for any dead time",
    ),
    (
        (Plant(num=[1, 2], den=[1, 1]), 0.1, "impulse"),
        "plant must have no feedthrough (deg num < deg den) for method 'impulse', got [1.0, 2.0]: "
        "a sampled impulse has no height; use method 'zoh' or 'foh'",
    ),
    # s = (2/dt)(z-1)/(z+1) and (1/dt)(z-1)/z reach 4 and 2 at z = infinity
    *(
        (
            (Plant(num=[1], den=[1, -pole]), 0.5, method),
            f"dt must not send the plant's pole at s = {pole} rad/s to z = infinity, got 0.5: "
            "sample faster, or use method 'zoh'",
        )
        for method, pole in (("tustin", 4), ("backward", 2))
    ),
    # e^1000 is 1e434; in e^(1e23) even the exponent is too long
    *(
        (
            (Plant(num=[1], den=[1, -1]), 1e3, method),
            "dt must keep the sampled system within a float's range, got 1000.0: "
            "sample faster: a coefficient outgrows 1e308",
        )
        for method in ("foh", "impulse", "matched")
    ),
]


def test_every_method_says_what_it_preserves():
    assert METHODS == PRESERVED
    for method in set(METHODS) - {"tustin", "prewarp"}:  # and says so where it is misunderstood
        with pytest.raises(SpecError) as refused:
            discretise(LAG, 0.1, method, prewarp=1.0)
        why = f"method {method!r} ({PRESERVED[method]}) has no such frequency"
        assert refused.value.way_out == why


@pytest.mark.parametrize(("asked", "text"), THERE)
def test_what_cannot_be_sampled(asked, text):
    with pytest.raises(SpecError) as refused:
        discretise(*asked)
    assert str(refused.value) == text


BACK = [
    (([1, 0.5], [1, 0]), "zoh", (
        "system must have no pole at z = 0 but those of a pure delay for method 'zoh', "
        "got [1.0, 0.0]: no plant has one: exp(s dt) is never 0; use method 'forward'"
    )),
    (([1], [1, 0.5]), "zoh", ON_NEGATIVE_AXIS.format("zoh")),
    (([1], [1, 0.5]), "matched", ON_NEGATIVE_AXIS.format("matched")),
    # z - 0.2 over z - 0.5 is no impulse response: 1, 0.3, 0.15 has no 0.6 to begin with
    (([1, -0.2], [1, -0.5]), "impulse", (
        "system must come back within 1e-09 when its plant is sampled again, got {}: "
        "this method did not make it, or its digits no longer hold the plant; "
        "use method 'tustin', whose inverse is exact"
    )),
    (([2], [1, 0]), "impulse", (
        "system must have a pole for method 'impulse', got [2.0]: "
        "a gain without poles has no sampled impulse response; use method 'zoh'"
    )),
    # z + 1 = 4/(2 - w); z = (2 + w)/(2 - w), at dt = 0.1 (1 + 0.05 w)
    (([1], [1, 1]), "tustin", IMPROPER.format(-1, [0.0, 2.0])),
    (([1], [1, 1]), "prewarp", IMPROPER.format(-1, [0.0, 2.0])),
    (([1, 1], [1, 0]), "backward", IMPROPER.format(0, [0.05, 1.0])),
]  # fmt: skip


@pytest.mark.parametrize(("system", "method", "text"), BACK)
def test_what_no_plant_was_sampled_to(system, method, text):
    num, den = system
    with pytest.raises(SpecError) as refused:
        undiscretise(
            Sampled(num=num, den=den, dt=0.1), method, 3.0 if method == "prewarp" else None
        )
    assert str(refused.value) == text.format(refused.value.value)


def test_what_is_on_the_wrong_side():
    sampled = Sampled(num=[1], den=[1, 1], dt=0.1)
    with pytest.raises(SpecError) as refused:
        discretise(sampled, 0.1, "tustin")
    assert str(refused.value) == (
        "system must be a zoh.Plant, got Sampled(num=(1.0,), den=(1.0, 1.0), dt=0.1): "
        "it is the continuous side"
    )
    assert refused.value.value is sampled
    with pytest.raises(SpecError) as refused:
        undiscretise(LAG, "zoh")
    assert str(refused.value) == (
        "system must be a zoh.Sampled, got Plant(num=(1.0,), den=(1.0, 1.0), dead_time=0.0, "
        "sensor=1.0): it is the sampled side"
    )
    assert refused.value.value is LAG


def test_prewarping_just_below_nyquist_is_possible():
    assert discretise(LAG, 1.0, "prewarp", pi * (1 - 1e-12)).dt == 1.0


@pytest.mark.parametrize("method", [m for m in METHODS if m != "prewarp"])
def test_a_numerator_below_all_floats_is_refused_by_every_method(method):
    """1/s^2 at dt 1e-200: dt^2 is 1e-400."""
    with pytest.raises(SpecError, match=r"^dt must leave the sampled plant a gain .* got 1e-200: "):
        discretise(Plant(num=[1], den=[1, 0, 0]), 1e-200, method)
    with pytest.raises(SpecError, match=r"^dt must leave the sampled plant a gain .* got 1e-200: "):
        discretise(Plant(num=[1], den=[1, 0, 0]), 1e-200, "prewarp", prewarp=1.0)

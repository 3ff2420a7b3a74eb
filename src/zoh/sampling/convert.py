"""Every way from s to z, by name, and the way back where there is one.

``discretise`` takes a plant or a continuous controller to a ``Sampled``; ``undiscretise`` finds
the plant that ``discretise`` turns into the system it is given. What each method keeps is said
once, in ``METHODS``.
"""

from collections.abc import Callable, Mapping
from decimal import Decimal
from math import pi

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.sampling import differences
from zoh.sampling.hold import sample, whole_samples
from zoh.sampling.rounding import with_a_gain

METHODS: Mapping[str, str] = {
    "zoh": "exact at the samples for an input held between them",
    "foh": "exact at the samples for an input in straight lines between them",
    "impulse": "dt times the impulse response at the samples",
    "tustin": "stability, and every gain with the frequency axis warped: w for s",
    "prewarp": "as tustin, with gain and phase exact at the frequency prewarp",
    "matched": "poles and zeros by z = exp(s dt), and the gain at zero frequency",
    "forward": "slow poles nearly (Euler); a stable plant may come out unstable",
    "backward": "slow poles nearly (Euler); a stable plant comes out stable",
}
"""Every method and what it preserves."""

_THETA: Mapping[str, Decimal] = {
    "tustin": differences.TUSTIN,
    "prewarp": differences.TUSTIN,
    "forward": differences.FORWARD,
    "backward": differences.BACKWARD,
}
_UNWARPED = Decimal(1)


def discretise(system: Plant, dt: float, method: str, prewarp: float | None = None) -> Sampled:
    """Return the plant (or the continuous controller) as a sampled system, sensor included.

    dt       s, above 0
    method   one of ``METHODS``
    prewarp  rad/s, inside (0, pi/dt): where gain and phase must be exact, for methods
             'prewarp' and 'tustin'

    Dead time: any for zoh, foh and impulse; a whole number of samples, which become z^-m, for
    the others. Whole samples are z^-m behind the system without them, num as it was: impulse and
    backward have zeros at z = 0, so that num and den may both end in zeros, and the way back
    knows which is which. A fraction of dt in foh makes the order one higher. Coefficients are
    right to their last digit in z and in w, at every dt.
    Raises SpecError for an unknown method, for numbers out of range and for what a method
    cannot do: feedthrough in impulse, a pole that a difference rule sends to infinity, a dt at
    which no float is small enough for the numerator.

    >>> lag = Plant(num=[1], den=[1, 1])
    >>> discretise(lag, 1.0, "backward")  # z/(2 z - 1)
    Sampled(num=(0.5, 0.0), den=(1.0, -0.5), dt=1.0)
    >>> abs(discretise(lag, 1.0, "prewarp", prewarp=2.0).at(2.0) - lag.at(2.0)) < 1e-15
    True
    """
    if not isinstance(system, Plant):
        raise SpecError("system", "must be a zoh.Plant", system, "it is the continuous side")
    return _forward(sample_time(dt), method, prewarp)(system)


def undiscretise(system: Sampled, method: str, prewarp: float | None = None) -> Plant:
    """Return the plant that ``discretise`` with the same method turns into this system.

    method, prewarp  as for ``discretise``

    tustin, prewarp, forward and backward are undone exactly. zoh, foh, impulse and matched take
    the logarithm of the poles, the one within the Nyquist frequency; none exists for poles at
    z = 0 (other than a pure delay, which is dead time) or on the negative real axis. A
    fraction of dt of dead time shows in the zeros alone: zoh and impulse answer with the plant
    behind whole samples that gives the same system, foh refuses.
    The result is sampled again and compared; its ``exact`` holds more digits than num and den
    show. Raises SpecError where no plant exists or 1e-9 is not reached.

    >>> undiscretise(Sampled(num=[0.5], den=[1, -0.5], dt=1.0), "zoh").den  # s + log 2
    (1.0, 0.6931471805599453)
    >>> undiscretise(Sampled(num=[1, 0], den=[2, -1], dt=1.0), "backward")  # z/(2 z - 1)
    Plant(num=(1.0,), den=(1.0, 1.0), dead_time=0.0, sensor=1.0)
    """
    if not isinstance(system, Sampled):
        raise SpecError("system", "must be a zoh.Sampled", system, "it is the sampled side")
    from zoh.sampling import inverse  # the way back is rarely gone, and long to load

    again = _forward(system.dt, method, prewarp)
    if method in _THETA:
        a = _stretch(system.dt, prewarp)
        return inverse.by_rule(system, _THETA[method], a, again)
    return inverse.by_logarithm(system, method, again)


def _forward(dt: float, method: str, prewarp: float | None) -> Callable[[Plant], Sampled]:
    """Return the method at this dt, its arguments checked."""
    if not isinstance(method, str) or method not in METHODS:
        raise SpecError("method", "must be a known method", method, f"one of {', '.join(METHODS)}")
    if prewarp is not None or method == "prewarp":
        _check_prewarp(dt, method, prewarp)
    a = _stretch(dt, prewarp)
    return lambda plant: with_a_gain(_sampled(plant, dt, method, a))


def _sampled(plant: Plant, dt: float, method: str, a: Decimal) -> Sampled:
    """Return the plant by this method; ``a`` is Tustin's factor."""
    from zoh.sampling import invariant, matched  # only where another hold is asked for

    if method == "zoh":
        return sample(plant, dt)
    if method == "foh":
        return invariant.ramp(plant, dt)
    if method == "impulse":
        return invariant.impulse(plant, dt)
    delay = _whole(plant, dt, method)
    if method == "matched":
        return matched.match(plant, dt, delay=delay)
    return differences.to_sampled(plant, dt, theta=_THETA[method], a=a, delay=delay)


def _stretch(dt: float, prewarp: float | None) -> Decimal:
    return _UNWARPED if prewarp is None else differences.stretch(float(prewarp), dt)


def _check_prewarp(dt: float, method: str, prewarp: float | None) -> None:
    if method not in ("tustin", "prewarp"):
        raise SpecError(
            "prewarp",
            "must be left out unless the method is 'tustin' or 'prewarp'",
            prewarp,
            f"method {method!r} ({METHODS[method]}) has no such frequency",
        )
    wp = checks.positive("prewarp", prewarp, "give the frequency in rad/s that must be exact")
    if not wp * dt < pi:
        raise SpecError(
            "prewarp",
            f"must be below the Nyquist frequency pi/dt = {pi / dt:.6g} rad/s",
            prewarp,
            f"lower it, or sample faster than dt = {pi / wp:.4g} s",
        )


def _whole(plant: Plant, dt: float, method: str) -> int:
    """Return the dead time in samples, or raise SpecError where it is not a whole number."""
    m, lead = whole_samples(plant.dead_time, 0.0, dt)
    if lead:
        raise SpecError(
            "dead_time",
            f"must be a whole number of samples ({dt!r} s each) for method {method!r}",
            plant.dead_time,
            "use method 'zoh', which is exact for any dead time",
        )
    return m

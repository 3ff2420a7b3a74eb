"""The margins of a loop, every crossing counted, z = 1 and z = -1 included.

Gain crossings are sign changes of |num|^2 - |den|^2, phase crossings those of
Im(num conj den) where the real part is negative; on the axis both are polynomials in
q = v^2, v = (2/dt) tan(w dt/2) for a sampled loop and v = w for a continuous one.

A sparse look comes first. Where exact arithmetic proves that it has missed nothing, that is
all; elsewhere the roots are isolated, exactly, or, where a delay leaves no polynomials, a look
from close by follows, and its proof.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sec. 10.3 and 13.2 (margins,
sensitivity peaks); P. Seiler, A. Packard, P. Gahinet, An Introduction to Disk Margins, IEEE
Control Systems 40(5), 2020, eq. (5) with sigma = 0.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from math import inf, isnan, log, radians, tau
from typing import TypeVar

import numpy as np

from zoh.analysis.blurred import blurs, is_blurred, next_to_the_axis
from zoh.analysis.certificates import Proof
from zoh.analysis.close import Close
from zoh.analysis.isolated import Isolated
from zoh.analysis.limit import says_on_the_limit
from zoh.analysis.loop import Loop
from zoh.analysis.margin_crossings import Crossings, gain_crossings, phase_crossings
from zoh.analysis.needles import deepest, ratio_at_end, runs_through
from zoh.analysis.proof import Found, Look, Peak, proved
from zoh.analysis.results import Margins
from zoh.analysis.rounding import doubts
from zoh.analysis.series import out_of_range
from zoh.analysis.sparse import Sparse
from zoh.analysis.squares import LONG, ON_DEN, ON_NUM, ON_OPPOSITE, Below, Squares
from zoh.analysis.stability import decided, next_to_it, surely
from zoh.errors import warn_of_accuracy
from zoh.lti.frequency_response import FrequencyResponse, TabledLoop
from zoh.lti.systems import Plant, Sampled

T = TypeVar("T")

_ON_IT_DEG = 1e-12  # a margin this small is 0: a few roundings of the angle
_NEEDLE = 1e-4  # |1 + L| below which its least value needs more digits than floats have
_CHEAP = 2.5  # samples of delay up to which a proof costs less than a look from close by


def within_floats(measured: Callable[[Loop], T]) -> Callable[[Loop], T]:
    """Return ``measured`` with SpecError for what is beyond floats; NumPy's words are not said."""

    @wraps(measured)
    def within(loop: Loop) -> T:
        try:
            with np.errstate(all="ignore"):
                return measured(loop)
        except (OverflowError, ZeroDivisionError):
            raise out_of_range([*loop.num, *loop.den]) from None

    return within


def margins(loop: Plant | Sampled | FrequencyResponse | TabledLoop) -> Margins:
    """Return the margins of ``loop``, the open loop of a unity negative feedback.

    Frequencies are real ones in rad/s, below or at Nyquist's. For a table, or a controller
    times one, the result is a ``zoh.TableMargins``. Raises SpecError for what is no system; warns
    (AccuracyWarning, and in the answer's ``warnings``) where rounding of the z-coefficients given
    has already lost a figure, and where one is not proved.

    >>> from math import pi
    >>> m = margins(Sampled(num=[0.1], den=[1, -0.9], dt=1.0))  # leaves at z = -1
    >>> round(m.gain_margin, 12), m.phase_crossover == pi
    (19.0, True)
    """
    if isinstance(loop, FrequencyResponse | TabledLoop):
        from zoh.analysis.tabled.margins import table_margins  # not for a model

        return table_margins(loop)
    found = measure_loop(Loop.of(loop))
    warn_of_accuracy(found.warnings)
    return found


@within_floats
def measure_loop(loop: Loop) -> Margins:
    """Return the margins of a loop on its frequency axis; raise SpecError beyond floats.

    What the figures rest on is in their ``warnings`` alone.
    """
    near = next_to_the_axis(loop)
    found = _looked_at(loop, decided(loop), near)
    asked = near or found.modulus_margin < _NEEDLE
    if asked and is_blurred(loop, found, near) and (finer := loop.finer()) is not loop:
        loop, found = finer, _looked_at(finer, decided(finer), near)
    given, left = loop, _unproved(found)
    if left and (plain := loop.without_shared()) is not None:
        loop, found = plain, _looked_at(plain, decided(loop), near)
        left = _unproved(found)
    if next_to_it(given, found.modulus_margin):
        found = _told(found, surely(given))
        left = _unproved(found)
    numbers = [found.gain_margin, found.phase_margin_deg, found.modulus_margin, found.mt]
    if any(map(isnan, [*numbers, found.disk_margin])):
        raise out_of_range([*loop.num, *loop.den])
    told = (*left, *doubts(loop, found), *(blurs(loop, found) if near else ()))
    return replace(found, warnings=told) if told else found


@within_floats
def glance(loop: Loop) -> Margins:
    """Return what ``measure_loop`` does; where a delay makes proofs dear, a look from close by.

    For a search, the answer of which is measured anew. Raises SpecError beyond floats.
    """
    if loop.dead_time <= _CHEAP * (loop.dt or 0.0):
        return _looked_at(loop, decided(loop), [])
    squares = Squares.of(loop)
    return _measured(loop, squares, Close.of(loop, squares), decided(loop), [], prove=False)


def nearest(by_gain: Crossings) -> tuple[float | None, float]:
    """Return the crossing whose margin is the nearest to 0; none is inf away."""
    return min(by_gain, key=lambda c: abs(c[1]), default=(None, inf))


def _looked_at(loop: Loop, stable: tuple[bool | None, Proof], near: list[float]) -> Margins:
    """Return what a sparse look shows where it is proved to be all, else what a longer one does.

    v of what may be beside a mode with next to no damping is added to ``near``.
    """
    squares = Squares.of(loop)
    look = Sparse.of(loop, squares)
    found = _measured(loop, squares, look, stable, near) if look else None
    if found is not None and _holds(found):
        return found
    if not squares.whole:
        found = _measured(loop, squares, Close.of(loop, squares), stable, near)
        if _holds(found) or not (squares := Squares.of(loop, LONG)).whole:
            return found
    return _measured(loop, squares, Isolated(squares=squares), stable, near)


def _holds(m: Margins) -> bool:
    return m.certificate is not None and m.certificate.holds


def _unproved(m: Margins) -> tuple[str, ...]:
    """Return a sentence for what the certificate leaves open: rounding, or a needle in a delay."""
    if m.certificate is None or m.certificate.holds:
        return ()
    limit = (m.certificate.stable.detail,) if says_on_the_limit(m.certificate.stable) else ()
    return (*limit, f"not proved to be complete: {', '.join(m.certificate.open())}")


def _told(m: Margins, decision: tuple[bool | None, Proof]) -> Margins:
    """Return the margins with this said of stability."""
    stable, why = decision
    proofs = None if m.certificate is None else replace(m.certificate, stable=why)
    return replace(m, stable=stable, certificate=proofs)


def _measured(
    loop: Loop, squares: Squares, look: Look, decision: tuple[bool | None, Proof],
    near: list[float], *, prove: bool = True,
) -> Margins:  # fmt: skip
    """Return everything that a look at the loop shows, with the proof that it is everything."""
    stable, why = decision
    unities, turns, drops = look.unities(), look.turns(), look.drops()
    by_phase = phase_crossings(loop, squares, unities, turns, near)
    by_gain = gain_crossings(loop, squares, unities, by_phase, near)
    peaks = [peak(loop, squares, look, below) for below in (ON_DEN, ON_NUM, ON_OPPOSITE)]
    if not isinstance(look, Sparse):
        near += [peak.v for peak in peaks]
    nearest_gain = min(by_phase, key=lambda c: abs(log(c[1])), default=(None, inf))
    factor = nearest_gain[1] if by_phase else None
    found = Found(unities, turns, drops, peaks, factor)
    certificate = proved(loop, squares, look, found, stable=why) if prove else None
    nearest_phase = nearest(by_gain)
    modulus, complementary, disk = peaks
    return Margins(
        stable=stable,
        gain_margin=nearest_gain[1],
        phase_crossover=nearest_gain[0],
        phase_margin_deg=nearest_phase[1],
        crossover=nearest_phase[0],
        delay_margin=_delay_margin(loop, by_gain),
        modulus_margin=modulus.least,
        ms_frequency=loop.frequency(modulus.v),
        mt=1 / complementary.least if complementary.least else inf,
        mt_frequency=loop.frequency(complementary.v),
        disk_margin=2 * disk.least,
        disk_frequency=loop.frequency(disk.v),
        bandwidth=loop.frequency(drops[0]) if drops else None,
        gain_crossings=tuple(by_gain),
        phase_crossings=tuple(by_phase),
        certificate=certificate,
        dt=loop.dt,
    )


def peak(loop: Loop, squares: Squares, look: Look, below: Below) -> Peak:
    """Return where |den + num|/|below| is least, both ends included."""
    place, value = _lowest(loop, squares, look, below)
    for v, top, bottom in loop.ends():
        under = abs(below[0] * bottom + below[1] * top)
        if not under:
            continue
        at_end = abs(bottom + top) / under
        if at_end < _NEEDLE:  # a difference
            at_end = ratio_at_end(loop, v, below)
        # where the least is at an end, the grid's outermost point says the same but for rounding
        if at_end <= value * (1 + 1e-14):
            place, value = v, at_end
    return Peak(place, value, below)


def _lowest(loop: Loop, squares: Squares, look: Look, below: Below) -> tuple[float, float]:
    """Return (v, the ratio there) of the least value that a look shows between the ends."""
    if isinstance(look, Isolated):
        place, value = look.least(below)
        return place, 0.0 if value < _NEEDLE and runs_through(squares) else value
    place = look.lowest(below)
    value = squares.ratio(place, below) if squares.whole else loop.ratio(place, below)
    if value < _NEEDLE and squares.whole:
        return deepest(squares, [place, *look.turns()], below)
    if value < _NEEDLE:  # narrower than a flat least value is told
        value, place = min((loop.ratio(v, below), v) for v in [place, *look.turns()])
    return place, value


def _delay_margin(loop: Loop, by_gain: Crossings) -> float:
    """Return the least delay in s that turns a crossing onto -1, or what a loud end allows.

    A gain of 1 or more at the highest frequencies bears no delay in a continuous loop: any turns
    it onto -1 somewhere. In a sampled one it bears less than one sample: at z = -1 an odd number
    of samples turns L round, and puts den + num there on the other side of 0.
    """
    _, top, bottom = loop.ends()[-1]
    loud = abs(top) >= abs(bottom)
    return min([_delay(w, pm) for w, pm in by_gain] + [loop.dt or 0.0] * loud, default=inf)


def _delay(w: float, pm_deg: float) -> float:
    """Return the delay in s that turns the loop at w rad/s onto -1; 0 where it is there."""
    return 0.0 if abs(pm_deg) < _ON_IT_DEG else radians(pm_deg) % tau / w

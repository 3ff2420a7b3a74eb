"""A continuous frequency response behind a hold, seen by a sampler: the sum of its images.

With ws = 2 pi/dt and w_n = w + n ws, every frequency that looks like w at the samples counts::

    G(exp(j w dt)) = (1 - exp(-j w dt))/dt  sum over n of  P(j w_n) exp(-j w_n delay)/(j w_n)

The images inside the table are summed. Those above it are not known; if the gain goes on
falling as it does in the table's last octave, |P(w)| <= |P(w_max)| (w_max/w)^r, their sum is at
most what is kept in ``neglected``.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 7.4 (aliasing,
the sampled response as a sum over images).
"""

from math import pi

import numpy as np

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.curve import Array
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.poly import ComplexArray
from zoh.lti.systems import sample_time

_EACH = 200  # images beyond the table bounded one by one; the rest by an integral
_LEAST_DT = 1e-300  # s; the last of those images is at some 1e303 rad/s then
_FALLING = 0.5  # r below which the gain can hardly be called falling; at 0 the sum has no bound


def sampled_table(
    table: FrequencyResponse, dt: float, compute_delay: float = 0.0
) -> FrequencyResponse:
    """Return the sampled response of a held continuous plant, at its table's points up to pi/dt.

    dt             s, above 0
    compute_delay  s, from sampling to output

    Raises SpecError for a table that is sampled already, or whose gain does not fall at its
    high end (by r of 0.5 or more, 10 dB per decade).

    >>> w = np.geomspace(0.1, 1e4, 400)
    >>> g = sampled_table(FrequencyResponse.from_complex(w=w, gain=1 / (1j * w)), dt=0.1)
    >>> off = abs(g.at(3.0) / (0.1 / (np.exp(0.3j) - 1)) - 1)  # the true one is dt/(z - 1)
    >>> off < g.neglected_at(3.0) < 4e-5
    True
    """
    if table.dt is not None:
        way_out = "it has its hold already; leave this step out"
        raise SpecError("dt", "must not be given twice", table.dt, way_out)
    dt = sample_time(dt)
    compute_delay = checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    if dt < _LEAST_DT:
        raise SpecError("dt", f"must be {_LEAST_DT:g} s or more", dt, "its images leave the floats")
    fall = -_high_slope(table)
    if fall < _FALLING:
        raise SpecError(
            "frequency_response",
            f"must fall by w^-{_FALLING:g} or more at its high end, or its images have no bound",
            float(-fall),
            "measure further up, or measure from the held input to the samples",
        )
    w = _up_to_nyquist(table.w, dt)
    total, square = _inside(table, w, dt, compute_delay)
    # (1 - exp(-j w dt))/dt without the difference, which a small dt would leave no digits
    size, hold = np.abs(total), 1j * w * np.exp(-0.5j * w * dt) * np.sinc(w * dt / (2 * pi))
    return FrequencyResponse(
        w=w,
        magnitude=np.abs(hold * total),
        phase_deg=np.degrees(np.angle(hold * total)),
        dt=dt,
        uncertainty=None if table.uncertainty is None else np.sqrt(square) / size,
        neglected=_outside(table, w, dt, fall) / size,
        unstable_poles=table.unstable_poles,
    )


def _up_to_nyquist(w: Array, dt: float) -> Array:
    """Return the frequencies below pi/dt, and pi/dt where the table has passed it."""
    kept = np.append(w[w < pi / dt], pi / dt) if w[-1] >= pi / dt else w
    if len(kept) < 3 and w[-1] >= pi / dt:
        raise SpecError("dt", "must leave two points below pi/dt", dt, "sample faster")
    return kept


def _inside(
    table: FrequencyResponse, w: Array, dt: float, delay: float
) -> tuple[ComplexArray, Array]:
    """Return the sum over the images inside the table, and the square of its 1 sigma.

    Each is taken for independent; at pi/dt, where an image and its mirror are one point of the
    table, that is too little by a factor of sqrt(2) at most.
    """
    low, high = table.band
    total, square = np.zeros(len(w), complex), np.zeros(len(w))
    known = np.log(table.w)
    most = int(high * dt / (2 * pi)) + 1
    for n in sorted(range(-most, most + 1), key=abs, reverse=True):  # the small ones first
        at = w + n * 2 * pi / dt
        seen = (np.abs(at) >= low) & (np.abs(at) <= high)
        size = np.abs(at[seen])
        gain = np.asarray(table.at(size)) * np.exp(-1j * size * delay) / (1j * size)
        total[seen] += np.where(at[seen] < 0, np.conj(gain), gain)
        if table.uncertainty is not None:
            each = np.interp(np.log(size), known, table.uncertainty)
            square[seen] += (np.abs(gain) * each) ** 2
    return total, square


def _outside(table: FrequencyResponse, w: Array, dt: float, fall: float) -> Array:
    """Return a bound on the sum over the images above the table."""
    ws, high = 2 * pi / dt, table.band[1]
    bound = np.zeros(len(w))
    for sign in (1, -1):
        first = np.ceil((high - sign * w) / ws)  # the first n with n ws + sign w >= high
        each = (first + np.arange(_EACH)[:, None]) * ws + sign * w
        each = np.where(each > high, each, np.inf)
        bound += ((high / each) ** fall / each).sum(axis=0)
        end = (first + _EACH - 1) * ws + sign * w
        bound += (high / end) ** fall / (fall * ws)  # the integral from the last one on
    return np.asarray(float(table.magnitude[-1]) * bound)


def _high_slope(table: FrequencyResponse) -> float:
    """Return d ln|P|/d ln w over the last octave, two points or more, by least squares."""
    x = np.log(table.w)
    many = max(2, len(x) - int(np.searchsorted(x, x[-1] - np.log(2.0))))
    x, y = x[-many:] - x[-many:].mean(), np.log(table.magnitude[-many:])
    return float(x @ y / (x @ x))

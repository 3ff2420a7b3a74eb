"""What is asked of many loops at once, a column each, and which of them floats can answer."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.batch.arrays import laws
from zoh.batch.arrays.rows import Array, Mask
from zoh.batch.columns import Columns, coefficients, column
from zoh.batch.job import Job
from zoh.lti.systems import Sampled

_ORDER = 6  # of the plant
_GIVEN = 3  # of a controller that is given
_OCTAVES = 30  # below Nyquist's frequency where the gain of a controller is looked at
_TAKEN_BACK = 1e4  # times what is left: of the effort 12 digits are then left, of the rest 9
_TAKES = frozenset({"wc", "pm_deg", "ki", "dc_gain", "filter_pole"})
_DELAYS = 4  # whole samples: each is a power in the loop and a state in its motion
_FASTEST = 1.2  # |s| dt of a plant's poles: beyond it two crests in one sample are usual; below
# they are rare, need three poles or more, and are seen: see ``turns``
_LARGE = 1e20  # of a number, or its inverse: beyond it others' rounding says what it does
_FAR = 1e12  # powers of |s| dt: further from 1 rounding leaves no digit of a pole near 0
_SQUARINGS = 4  # of the poles: their sizes then differ by the 16th power, and a bound's 12 is 1.17


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """Loops of one law, a column each.

    num, den     the plant with its sensor, rows of ascending powers of s, equally many; the last
                 row of den is 1
    delay, lead  samples of dead time and compute delay: delay - lead, 0 <= lead < 1
    asked        the law's parameters;  regular  what is within every bound
    beyond       what is, but for a crossover that is not below Nyquist's frequency
    """

    num: Array
    den: Array
    dt: Array
    delay: npt.NDArray[np.int64]
    lead: Array
    asked: dict[str, Array]
    regular: Mask
    beyond: Mask


def lacks(job: Job) -> str:
    """Return what of this job these arithmetics cannot do, "" where they can do all of it.

    A plant that answers at once jumps within a sample, which is left to the single design.

    >>> from zoh.lti.systems import Plant
    >>> lacks(Job(plant=Plant(num=[1, 2], den=[1, 0]), law="p", asked={"wc": 1}, dt=0.1))
    'a plant that is not strictly proper'
    """
    num, den = coefficients(job, {}, 1)
    if len(num) >= len(den):
        return "a plant that is not strictly proper"
    if len(den) > _ORDER + 1:
        return f"a plant of order {len(den) - 1}, above {_ORDER}"
    if job.sections:
        return "sections"
    if job.controller is not None:
        order = len(job.controller.den_w) - 1
        if job.controller.delay:
            return "a controller with a delay of its own"
        if order > _GIVEN:
            return f"a controller of order {order}, above {_GIVEN}"
        return (
            "a controller that takes back most of its direct gain" if _falls(job.controller) else ""
        )
    if job.law not in laws.LAWS:
        return f"the law {job.law}"
    asked = {*job.asked, *(key for key in job.varying if key in job.law_keys)}
    missing, more = {"wc", "pm_deg"} - asked, asked - _TAKES
    if missing:
        return f"a {job.law} without {', '.join(sorted(missing))}"
    return ", ".join(sorted(more))


def _falls(given: Sampled) -> bool:
    """Return whether a controller's gain falls far below its direct one, as that of leads does.

    Its effort is then a difference of sums that are so many times larger. A notch is no wider than
    an octave, and is passed over.
    """
    size = np.abs(given.at(np.pi / given.dt / 2.0 ** np.arange(_OCTAVES)))
    around = np.maximum(np.maximum(size[:-2], size[1:-1]), size[2:])
    direct = given.num[0] / given.den[0] if len(given.num) == len(given.den) else 0.0
    return bool(abs(direct) > _TAKEN_BACK * around.min())


@np.errstate(all="ignore")  # here, too: a thread of its own has not its caller's
def batch(job: Job, columns: Columns, n: int) -> Batch:
    """Return what is asked of n loops."""
    num, den = coefficients(job, columns, n)
    dt = column(job, columns, "dt", n)
    late = column(job, columns, "dead_time", n) + column(job, columns, "compute_delay", n)
    asked = {
        key: column(job, columns, key, n)
        for key in job.law_keys
        if key in job.asked or key in columns
    }
    regular = (dt > 0) & (late >= 0) & (den[0] != 0)
    regular &= num[-1] != 0  # a zero at s = 0: what is left of a final value of 0 is rounding
    for values in asked.values():
        regular &= values > 0
    beyond = np.zeros(n, bool)
    num, den = num[::-1] * (job.plant.sensor / den[0]), den[::-1] / den[0]
    rates = _rates(den, dt)
    regular &= _ordinary(job, [*num, *den, dt, *asked.values()], rates)
    if "pm_deg" in asked:
        beyond = regular & ~(asked["wc"] * dt < np.pi)
        regular &= (asked["pm_deg"] < 180) & ~beyond
    delay, lead = _in_samples(late, dt)
    regular &= delay <= _DELAYS
    num = np.concatenate([num, np.zeros((len(den) - len(num), n))])
    regular &= _turns_once(den) | (_fastest(rates) <= _FASTEST)
    return Batch(
        num=num, den=den, dt=dt, delay=np.where(regular, delay, 0).astype(np.int64), lead=lead,
        asked=asked, regular=regular, beyond=beyond,
    )  # fmt: skip


def _rates(den: Array, dt: Array) -> Array:
    """Return the denominator in s dt, descending powers; den in ascending ones of s."""
    rates, power = den[::-1].copy(), dt
    for row in rates[1:]:
        row *= power
        power = power * dt
    return rates


def _in_samples(late: Array, dt: Array) -> tuple[Array, Array]:
    """Return (the whole samples that are not less, by how much of one they are more)."""
    if not late.any():
        return late, late
    ratio = late / dt
    whole = np.abs(ratio - np.round(ratio)) <= 8 * np.spacing(ratio)
    delay = np.where(whole, np.round(ratio), np.ceil(ratio))
    return delay, np.where(whole, 0.0, (delay * dt - late) / dt)


def _ordinary(job: Job, rows: list[Array], rates: Array) -> Mask:
    """Return whether no power or product of a loop's numbers comes near the end of a float.

    rows  the numbers;  rates  the denominator's in s dt
    """
    given = [job.reference]
    if job.controller is not None:
        given += [*job.controller.num_w, *job.controller.den_w]
    constant = all(x == 0 or 1 / _LARGE <= abs(x) <= _LARGE for x in given)
    ordinary = np.full(rates.shape[1], constant)
    for row in rows:
        if not 1 / _LARGE <= row.min() <= row.max() <= _LARGE:  # the ends of a row cost the least
            size = np.abs(row)
            ordinary &= (size == 0) | ((size >= 1 / _LARGE) & (size <= _LARGE))
    for row in rates:
        if not -_FAR <= row.min() <= row.max() <= _FAR:
            ordinary &= np.abs(row) <= _FAR
    return ordinary


def _turns_once(den: Array) -> Mask:
    """Return whether under a held input the output turns once at most, however long it is held.

    Its slope is a sum of as many exponentials as there are poles: where two are real, of two.
    Source: G. Polya, G. Szego, Problems and Theorems in Analysis, vol. 2, part 5, no. 75 (the zeros
    of a sum of real exponentials are fewer than its terms).
    """
    order = len(den) - 1
    if order == 2:
        return np.asarray(den[1] ** 2 >= 4 * den[0])
    return np.full(den.shape[1], order < 2)


def _fastest(a: Array) -> Array:
    """Return bounds of the poles' |s| dt, 1.17 times the truth at most where that matters.

    a  the plant's denominator in s dt, monic, descending powers
    Source: M. Fujiwara, Tohoku Math. J. 10 (1916), the bound; P. Henrici, Applied and Computational
    Complex Analysis, vol. 1, sec. 6.7 (Graeffe's squaring of the roots).
    """
    bound = _fujiwara(a)
    if np.all(bound <= _FASTEST):
        return bound
    n = len(a) - 1
    for _ in range(_SQUARINGS):
        squared = a * a
        for j in range(n + 1):
            for i in range(1, min(j, n - j) + 1):
                squared[j] += (-1) ** i * 2 * a[j - i] * a[j + i]
        a = squared
    return np.asarray(np.minimum(bound, _fujiwara(a) ** (1 / 2**_SQUARINGS)))


def _fujiwara(a: Array) -> Array:
    most = np.zeros(a.shape[1])
    for k, row in enumerate(a):
        if k:
            np.maximum(most, np.abs(row) ** (1 / k), out=most)
    return np.asarray(2 * most)

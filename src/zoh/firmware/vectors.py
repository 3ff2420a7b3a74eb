"""Inputs that leave no corner out, the same ones at every run.

A linear congruential generator stands for chance: nothing here depends on a seed, a clock or the
version of a library.
Source: D. E. Knuth, The Art of Computer Programming, vol. 2, sec. 3.3.4 (the multiplier of MMIX).
"""

from collections.abc import Iterator
from math import inf, nan

from zoh.firmware.book import IO_BITS
from zoh.firmware.plan import Plan

Sample = tuple[float, float, float]  # r, y, ff
_MASK = (1 << 64) - 1
_EDGES_F32 = (0.0, -0.0, nan, inf, -inf, 1e-45, -1e-45, 1.1754944e-38, 3.4028234e38, -3.4028234e38)
_EDGES_F64 = (*_EDGES_F32[:5], 5e-324, -5e-324, 2.2250738585072014e-308, 1.7e308, -1.7e308)


def chance(start: int) -> Iterator[int]:
    """Yield whole numbers of 32 bits.

    >>> numbers = chance(0)
    >>> next(numbers)  # 1442695040888963407 // 2^32
    335903614
    """
    state = start
    while True:
        state = (state * 6364136223846793005 + 1442695040888963407) & _MASK
        yield state >> 32


def hostile(plan: Plan, count: int, start: int = 1) -> list[Sample]:
    """Return ``count`` samples: steps, ramps, chance, rails, bursts and what is hardly a number.

    Floats get NaN, infinities, subnormals and the largest numbers, alone and in bursts, between
    stretches of ordinary ones; whole numbers are of the format, with every mix of its ends.
    """
    numbers = chance(start)
    if plan.number in IO_BITS:
        return [_whole(next(numbers), k, numbers, plan) for k in range(count)]
    return [_float(next(numbers), k, numbers, plan) for k in range(count)]


def ordinary(plan: Plan, count: int, start: int = 1) -> list[Sample]:
    """Return samples as a loop in use has them: a step of r, y on its way, a little of ff."""
    numbers = chance(start)
    top = 1.0 if plan.number not in IO_BITS else (1 << IO_BITS[plan.number] - 1) - 1
    samples = []
    for k in range(count):
        noise = (next(numbers) / 2**32 - 0.5) * 0.02
        r, y = 0.5 * (k // 8 % 2), 0.5 * (1 - 0.8 ** (k % 8)) * (1 if k // 8 % 2 else -1) + noise
        ff = 0.1 * (k // 4 % 3 - 1)
        samples.append(_of_format((r * top, y * top, ff * top), plan))
    return samples


def _of_format(sample: Sample, plan: Plan) -> Sample:
    if plan.number in IO_BITS:
        return round(sample[0]), round(sample[1]), round(sample[2])
    return sample


def _whole(draw: int, k: int, numbers: Iterator[int], plan: Plan) -> Sample:
    bits = IO_BITS[plan.number]
    low, high = -(1 << bits - 1), (1 << bits - 1) - 1

    def any_of() -> int:
        return low + ((next(numbers) << 32 | next(numbers)) >> 64 - bits)

    def small() -> int:
        return any_of() >> bits // 2

    kind = k // 64 % 8
    if kind == 0:
        return small(), small(), 0
    if kind == 1:  # rails, held
        return (high, low, 0) if k // 16 % 2 else (low, high, 0)
    if kind == 2:  # bursts between the ends
        ends = (low, high, 0, -1)
        return ends[draw % 4], ends[(draw >> 2) % 4], ends[(draw >> 4) % 4]
    if kind == 3:  # ramps
        ramp = low + (k % 64) * ((high - low) // 63)
        return ramp, -1 - ramp, small()
    if kind == 4:
        return any_of(), any_of(), any_of()
    if kind == 5:  # one step at a time
        return k % 3 - 1, k % 5 - 2, 0
    return (high // 4, small(), small()) if kind == 6 else (any_of(), small() * (draw % 3 - 1), 0)


def _float(draw: int, k: int, numbers: Iterator[int], plan: Plan) -> Sample:
    edges = _EDGES_F32 if plan.number == "f32" else _EDGES_F64

    def any_of() -> float:
        return (next(numbers) / 2**31 - 1.0) * 2.0 ** (next(numbers) % 12 - 6)

    def edge() -> float:
        return edges[next(numbers) % len(edges)]

    kind = k // 64 % 8
    if kind == 0 and k % 64 < 3:
        return edge(), any_of(), 0.0
    if kind == 1:
        return (1e3, -1e3, 0.0) if k // 16 % 2 else (-1e3, 1e3, 0.0)
    if kind == 2:  # bursts
        return 1.0 if draw % 2 else -1.0, 1.0 if draw & 2 else -1.0, 0.5 if draw & 4 else -0.5
    if kind == 3:
        return (k % 64) / 32 - 1, 1 - (k % 64) / 32, any_of() * 0.01
    if kind == 4 and draw % 4 == 0:
        return edge(), edge(), edge()
    tiny, large = (-130, 110) if plan.number == "f32" else (-1030, 1000)
    if kind == 5:  # subnormal and tiny
        return any_of() * 2.0**tiny, any_of() * 2.0 ** (tiny - 10), 0.0
    if kind == 6 and draw % 16 == 0:
        return any_of() * 2.0**large, any_of() * 2.0**large, any_of() * 2.0**large
    size = 2.0**-10 if kind == 7 else 1.0  # a controller of high gain is seldom off its limits
    return any_of() * size, any_of() * size, any_of() * 0.1 if draw % 2 else 0.0

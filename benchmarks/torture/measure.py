"""Everything that is true of a loop, written down: ``python -m benchmarks.torture.measure``.

Beside the margins there is what cannot be decided. A crossing that comes or goes when every
coefficient is moved by its last bit is no property of the loop somebody meant: it is marked, and
neither finding it nor leaving it out is counted against anybody.
"""

import random
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from math import nextafter
from typing import Any

from benchmarks.torture import audit, delay, loops, truth
from benchmarks.torture.exact import add
from benchmarks.torture.loops import Spec
from benchmarks.torture.truth import Crossings, Loop
from mpmath import mp, mpf

COPIES = 4  # with the last bits moved
Pair = tuple[mpf, mpf]


def measured(spec: Spec) -> dict[str, Any]:
    """Return what is true of a loop, numbers as decimal strings."""
    with mp.workdps(truth.WORK):
        loop = loops.exact_loop(spec)
        seen, stable = truth.crossings(loop), truth.stable(loop)
        peaks = _peaks(loop)
        audit.check(loop, seen, peaks[0])
        others = [loops.exact_loop(s) for s in _moved(spec)]
        doubt = _doubt(seen, [truth.crossings(o) for o in others], loop)
        out = {
            "name": spec["name"],
            "stable": stable,
            "gains": [_short(pair) for pair in seen.gains],
            "phases": [_short(pair) for pair in seen.phases],
            "modulus": text(peaks[0]), "mt": text(1 / peaks[1] if peaks[1] else mp.inf),
            "disk": text(2 * peaks[2]),
        }  # fmt: skip
        doubt["stable"] = any(truth.stable(o) != stable for o in others)
        return out | {"doubt": {k: v for k, v in doubt.items() if v}}


def _peaks(loop: Loop) -> tuple[mpf, mpf, mpf]:
    """Return min |1 + L|, min |1 + 1/L| and min |1 + L|/|1 - L|."""
    if loop.dead_time:
        pairs = [((1, 1), (1, 0)), ((1, 1), (0, 1)), ((1, 1), (1, -1))]
        found = [delay.least_ratio(loop, top, bottom) for top, bottom in pairs]
    else:
        closed, open_ = add(loop.den, loop.num), add(loop.den, loop.num, -1)
        found = [truth.least_ratio(loop, closed, a) for a in (loop.den, loop.num, open_)]
    return found[0][0], found[1][0], found[2][0]


def _moved(spec: Spec) -> Iterator[Spec]:
    """Yield copies with every coefficient that is not 0 moved up or down by its last bit."""
    for i in range(COPIES):
        rng = random.Random(f"{spec['name']}/{i}")

        def move(a: list[float], rng: random.Random = rng) -> list[float]:
            return [nextafter(c, rng.choice([-1, 1]) * float("inf")) if c else c for c in a]

        if spec["form"] != "params":
            yield {**spec, "num": move(spec["num"]), "den": move(spec["den"])}
            continue
        plant, law = spec["plant"], spec["controller"]
        plant = {**plant, "num": move(plant["num"]), "den": move(plant["den"])}
        if "num" in law:
            law = {**law, "num": move(law["num"])}
        else:
            law = dict(zip(law, move(list(law.values())), strict=True))
        yield {**spec, "plant": plant, "controller": law}


def _doubt(seen: Crossings, others: list[Crossings], loop: Loop) -> dict[str, Any]:
    """Return the crossings that come and go with the last bits."""
    nyquist = mp.pi / mpf(loop.dt) if loop.dt is not None else mp.inf
    out: dict[str, list[Any]] = {"gains": [], "phases": []}
    for kind, found in out.items():
        loose: dict[str, Any] = {}
        for other in others:
            for pair in _unpaired(getattr(seen, kind), getattr(other, kind), nyquist):
                loose.setdefault(mp.nstr(pair[0], 3), _short(pair))
        found.extend(loose.values())
    return out


def _unpaired(one: list[Pair], two: list[Pair], nyquist: mpf) -> list[Pair]:
    """Return what is left of two lists after the nearest have found each other, end with end."""
    left: list[Pair] = []
    for here in (mpf(0), nyquist):
        at_end = [[c for c in pairs if c[0] == here] for pairs in (one, two)]
        if len(at_end[0]) != len(at_end[1]):
            left += [*at_end[0], *at_end[1]]
        one, two = ([c for c in pairs if c[0] != here] for pairs in (one, two))
    if len(one) == len(two):
        return left
    near = sorted(
        (abs(mp.log(a[0] / b[0])), i, j) for i, a in enumerate(one) for j, b in enumerate(two)
    )
    free = [set(range(len(one))), set(range(len(two)))]
    for _, i, j in near:
        if i in free[0] and j in free[1]:
            free[0].remove(i)
            free[1].remove(j)
    return left + [one[i] for i in free[0]] + [two[j] for j in free[1]]


def text(x: mpf) -> str:
    return "inf" if mp.isinf(x) else mp.nstr(x, truth.DIGITS, min_fixed=-4, max_fixed=6)


def _short(pair: Pair) -> list[str]:
    return [text(x) for x in pair]


def main() -> None:
    """Write truth.json.gz; nothing is written where one loop could not be measured."""
    specs = loops.read(loops.LOOPS)
    found: list[Spec] = []
    failed: list[str] = []
    with ProcessPoolExecutor() as pool:
        for i, item in enumerate(pool.map(_tried, specs, chunksize=8), 1):
            if isinstance(item, str):
                failed.append(item)
            else:
                found.append(item)
            if i % 100 == 0:
                sys.stderr.write(f"{i} of {len(specs)}\n")
    if failed:
        sys.exit("\n".join(failed))
    loops.write(loops.TRUTH, found)


def _tried(spec: Spec) -> dict[str, Any] | str:
    try:
        return measured(spec)
    except (ArithmeticError, ValueError) as error:
        return f"{spec['name']}: {error!r}"


if __name__ == "__main__":
    main()

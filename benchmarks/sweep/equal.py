"""Arrays and the compiled arithmetic beside the single design, figure by figure, on random loops.

    python -m benchmarks.sweep.equal --loops 100000 [--seed 0] [--jobs 2]

draws families of loops: a plant (order 1 to 6, with and without integrators, swinging, unstable),
a law, a delay of 0 to 4 samples, dt over four decades, crossovers over two, margins of 15 to 85
degrees; in one family of eight a given controller that places closed-loop poles anywhere in the
circle, on a plant of order 3 to 6. Every reason and every figure of both arithmetics must be the
single design's, to 1e-9 and what ``allowed`` adds with its reason. Prints how many loops there were
of each reason, the worst of each figure in parts of what is allowed, and each family that differs
with its seed; exits 1 where one does.
"""

import argparse
import sys
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import numpy.typing as npt

import zoh
from zoh.analysis.motion import QUIET
from zoh.batch import single
from zoh.batch.arrays import run as arrays
from zoh.batch.job import Job
from zoh.batch.reason import Reason

Array = npt.NDArray[np.float64]
Columns = dict[str, Array]
LAWS = ("p", "pi", "pid", "pd", "lag", "lead", "given")
PLACED = 8  # one family in so many has a controller that places poles
DELAYS = (0.0, 0.3, 0.5, 1.0, 1.5, 2.7, 4.0)  # samples
FAMILY = 100  # loops


def spread(
    model: zoh.Plant, law: str, late: float, loops: int, rng: np.random.Generator
) -> tuple[Job, Columns]:
    """Return a job and columns: dt over four decades, crossovers over two, any margin."""
    fastest = max(float(np.abs(model.poles()).max()), 0.5)
    dt = 10 ** rng.uniform(-4, 0, loops) / fastest
    wc = np.minimum(10 ** rng.uniform(-1.3, 0.6, loops) * fastest, 3.3 / dt)
    gain = np.abs(model.at(wc))
    columns = {"dt": dt, "compute_delay": late * dt}
    if law == "given":
        controller = zoh.Sampled(num=[1.2 / gain[0], -1.05 / gain[0]], den=[1, -0.7], dt=0.1)
        columns["plant.gain"] = model.num[0] / model.den[0] * 10 ** rng.uniform(-1, 1, loops)
        job = Job(
            plant=model, law=law, controller=controller, dt=0.1, reference=-2.0,
            varying=tuple(columns),
        )  # fmt: skip
        return job, columns
    columns |= {"wc": wc, "pm_deg": rng.uniform(15, 85, loops)}
    if law == "p":  # its margin is what the plant leaves
        columns["pm_deg"] = np.array(
            [left(model, *at) for at in zip(dt, late * dt, wc, strict=True)]
        )
    elif law == "pid":
        columns["ki"] = wc / gain * 10 ** rng.uniform(-3, -0.5, loops)
    elif law in ("lag", "lead"):
        low, high = (0.02, 1.5) if law == "lag" else (-1.5, -0.02)
        columns["dc_gain"] = 10 ** rng.uniform(low, high, loops) / gain
    return Job(plant=model, law=law, dt=0.1, reference=-2.0, varying=tuple(columns)), columns


def placed(loops: int, rng: np.random.Generator) -> tuple[Job, Columns, float]:
    """Return a job, columns and samples of delay: a controller that places the poles anywhere.

    The plant has order 3 to 6, its fastest pole 0.1 to 1.2 of a sample's inverse. With more poles
    than a controller of order 3 can place, it is made for the plant without its fastest ones, and
    its gain halved until the loop is stable. Fast closed-loop poles swing the plant's input, and
    its output between the samples with it.
    """
    order, gain = int(rng.integers(3, 7)), 0.0
    while not gain:
        late = float(rng.choice([0.0, 0.0, 0.3]))
        model = stable_plant(order, rng)
        dt = float(10 ** rng.uniform(-1, 0) * 1.2 / np.abs(model.poles()).max())
        slow = without_fastest(model, order - 4 + (late > 0))
        controller = placing(zoh.sample(slow, dt, late * dt), rng)
        if np.abs(controller.den).max() < 10:
            gain = stable_gain(zoh.sample(model, dt, late * dt) * controller)
    controller = zoh.Sampled(num=[gain * c for c in controller.num], den=controller.den, dt=dt)
    columns = {"plant.gain": model.num[0] / model.den[0] * rng.uniform(0.97, 1.03, loops)}
    job = Job(
        plant=model, law="given", controller=controller, dt=dt, compute_delay=late * dt,
        varying=tuple(columns),
    )  # fmt: skip
    return job, columns, late


def stable_gain(loop: zoh.Sampled) -> float:
    """Return the first of 1, 1/2, ..., 1/32 that as a gain leaves the loop stable, or 0."""
    for gain in 0.5 ** np.arange(6.0):
        poles = np.roots(np.polyadd(gain * np.array(loop.num), loop.den))
        if np.abs(poles).max() < 0.99:
            return float(gain)
    return 0.0


def stable_plant(order: int, rng: np.random.Generator) -> zoh.Plant:
    """Return a stable plant of this order, its poles over one decade or two; some swing."""
    poles: list[complex] = []
    while len(poles) < order:
        pole = -(10 ** rng.uniform(-1, 1)) + 0j
        if order - len(poles) > 1 and rng.random() < 0.4:
            pole *= np.exp(1j * rng.uniform(0.2, 1.5))
            poles.append(pole.conjugate())
        poles.append(pole)
    zeros = -(10 ** rng.uniform(-1, 1, int(rng.integers(0, order - 1))))
    num, den = (np.atleast_1d(np.poly(roots)).real for roots in (zeros, poles))
    return zoh.Plant(num=(num * den[-1] / num[-1]).tolist(), den=den.tolist())


def without_fastest(model: zoh.Plant, many: int) -> zoh.Plant:
    """Return the plant without so many of its fastest poles, one more where a pair would be cut.

    As many zeros go as must; the gain at rest stays.
    """
    poles = sorted(model.poles(), key=abs)
    keep = len(poles) - max(many, 0)
    if abs(np.poly(poles[:keep]).imag).max() > 1e-9 * abs(np.poly(poles[:keep])).max():
        keep -= 1
    den = np.poly(poles[:keep]).real
    num = np.poly(sorted(np.roots(model.num), key=abs)[: keep - 1]).real
    return zoh.Plant(
        num=(np.atleast_1d(num) * den[-1] / np.atleast_1d(num)[-1]).tolist(), den=den.tolist()
    )


def placing(plant: zoh.Sampled, rng: np.random.Generator) -> zoh.Sampled:
    """Return the controller, one order below the plant's, that places random closed-loop poles."""
    den = np.array(plant.den)
    n = len(den) - 1
    num = np.concatenate([np.zeros(n + 1 - len(plant.num)), plant.num])
    poles: list[complex] = []
    while len(poles) < 2 * n - 1:
        pole = rng.uniform(-0.7, 0.95) + 0j
        if 2 * n - 1 - len(poles) > 1 and rng.random() < 0.5:
            pole = abs(pole) * np.exp(1j * rng.uniform(0.1, 3.0))
            poles.append(pole.conjugate())
        poles.append(pole)
    rows = np.zeros((2 * n, 2 * n))  # of den x (controller's den) + num x (controller's num)
    for i in range(n):
        rows[i : i + n + 1, i], rows[i : i + n + 1, n + i] = den, num
    found = np.linalg.lstsq(rows, np.poly(poles).real)[0]  # plants that cannot be placed, too
    return zoh.Sampled(num=found[n:].tolist(), den=found[:n].tolist(), dt=plant.dt)


def left(model: zoh.Plant, dt: float, delay: float, wc: float) -> float:
    """Return the margin in deg that the sampled plant has at wc by itself."""
    return float(np.degrees(np.angle(-zoh.sample(model, dt, delay).at(wc))))


def plant(rng: np.random.Generator) -> zoh.Plant:
    """Return a strictly proper plant of order 1 to 6, its gain 1 at its fastest pole but for 10."""
    order = int(rng.integers(1, 7))
    poles: list[complex] = [0j] * int(rng.integers(0, min(order, 2) + 1))
    while len(poles) < order:
        fast = 10 ** rng.uniform(-1, 1)
        if order - len(poles) > 1 and rng.random() < 0.4:
            pole = -fast * np.exp(1j * np.arccos(10 ** rng.uniform(-2, -0.05)))
            poles += [pole, pole.conjugate()]
        else:
            poles.append(complex(fast if rng.random() < 0.08 else -fast))
    zeros = [-(10 ** rng.uniform(-1, 1.5)) for _ in range(int(rng.integers(0, min(order, 3))))]
    num, den = (np.atleast_1d(np.poly(roots)).real for roots in (zeros, poles))
    gain = abs(np.polyval(num, 1j) / np.polyval(den, 1j))
    return zoh.Plant(num=(num * 10 ** rng.uniform(-1, 1) / gain).tolist(), den=den.tolist())


def allowed(name: str, truth: Mapping[str, Array], dt: Array | float) -> Array:
    """Return by how much a figure may be off, sampled every dt s."""
    tolerance: Array = 1e-9 * np.abs(truth[name])
    if name.endswith("overshoot_pct"):
        tolerance += 1e-10  # % of the final value: a few hundred roundings of it
    elif name == "steady_state_error":
        tolerance += 1e-12  # of the reference: it is the difference of two numbers near 1
    elif name.endswith("peak_time"):
        # a crest is flat: h above the final value it falls by h (w t)^2/2, which rounding, 1e-13 of
        # the final value, hides for sqrt(2e-13/h)/w; 1/w is about that of the crossover, or for a
        # slow crest about its own time
        h, crossover = truth[name.replace("peak_time", "overshoot_pct")] / 100, truth["crossover"]
        slow = np.fmax(1 / crossover, np.abs(truth[name]))
        tolerance += np.sqrt(2e-13 / np.where(h > 0, h, 1.0)) * slow
        # and where a sample is so short that h falls by less than 1e-9 in one, the output may by
        # chance be level, but for rounding, from one end of a straight piece to the other
        tolerance += np.where(h * (dt / slow) ** 2 < 1e-9, dt, 0.0)
    return tolerance


def differences(
    found: Mapping[str, Array], truth: Mapping[str, Array], dt: Array | float
) -> Iterator[str]:
    """Yield a line for every reason and figure that is not the truth's: name, loop, both values."""
    for i in np.flatnonzero(found["reason"] != truth["reason"]).tolist():
        yield f"reason of {i}: {Reason(found['reason'][i]).name}, {Reason(truth['reason'][i]).name}"
    for i in np.flatnonzero(found["stable"] != truth["stable"]).tolist():
        yield f"stable of {i}: {found['stable'][i]}, {truth['stable'][i]}"
    for name, parts in worst(found, truth, dt).items():
        for i in np.flatnonzero(~(parts <= 1)).tolist():
            yield f"{name} of {i}: {found[name][i]!r}, {truth[name][i]!r}"


def worst(
    found: Mapping[str, Array], truth: Mapping[str, Array], dt: Array | float
) -> dict[str, Array]:
    """Return how far each figure of each loop is off, in parts of what is allowed."""
    parts = {}
    for name in sorted(set(truth) - {"stable", "reason"}):
        x, y = found[name], truth[name]
        same = (x == y) | (np.isnan(x) & np.isnan(y)) | after_the_horizon(name, found, truth)
        with np.errstate(invalid="ignore", divide="ignore"):  # where one of them does not exist
            off = np.abs(x - y) / allowed(name, truth, dt)
        parts[name] = np.where(same, 0.0, np.where(np.isnan(off), np.inf, off))
    return parts


def after_the_horizon(
    name: str, found: Mapping[str, Array], truth: Mapping[str, Array]
) -> npt.NDArray[np.bool_]:
    """Return where a figure is that of an overshoot which only one of the two has seen.

    Each follows a response until its slowest mode has fallen to QUIET, the fast ones to the end of
    a block: an overshoot of no more than that part of the final value may come later.
    """
    of = "between.overshoot_pct" if name.startswith("between.") else "overshoot_pct"
    x, y = found[of], truth[of]
    unseen = ((x == 0) != (y == 0)) & (np.fmax(x, y) < 100 * QUIET)
    return unseen & (name in (of, of.replace("overshoot_pct", "peak_time"), "peak"))


def family(seed: int) -> tuple[Counter[str], dict[str, float], list[str]]:
    """Return what came of one family: loops by reason, the worst of each figure, differences."""
    from zoh.batch.compiled import run as compiled

    warnings.simplefilter("ignore", zoh.AccuracyWarning)
    rng = np.random.default_rng([seed, 5])
    if seed % PLACED == PLACED - 1:
        job, columns, late = placed(FAMILY, rng)
    else:
        model, law, late = plant(rng), LAWS[seed % len(LAWS)], float(rng.choice(DELAYS))
        job, columns = spread(model, law, late, FAMILY, rng)
    truth, dt = single.run(job, columns), columns.get("dt", job.dt)
    counts = Counter(Reason(r).name for r in truth["reason"])
    most: dict[str, float] = {}
    told = []
    for way, found in (
        ("arrays", arrays.run(job, columns)),
        ("compiled", compiled.run(job, columns, threads=1)),
    ):
        for name, parts in worst(found, truth, dt).items():
            most[name] = max(most.get(name, 0.0), float(parts.max()))
        about = f"family {seed}, {job.law} on {job.plant}, {late} dt"
        told += [f"{about}: {way}: {line}" for line in differences(found, truth, dt)]
    return counts, most, told


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0, help="of the first family")
    parser.add_argument("--jobs", type=int, default=1)
    asked = parser.parse_args()
    families = range(asked.seed, asked.seed + -(-asked.loops // FAMILY))
    counts: Counter[str] = Counter()
    most: dict[str, float] = {}
    wrong = 0
    with ProcessPoolExecutor(asked.jobs) as pool:
        for i, (its_counts, its_most, told) in enumerate(pool.map(family, families)):
            counts += its_counts
            most |= {name: max(x, most.get(name, 0.0)) for name, x in its_most.items()}
            wrong += len(told)
            for line in told:
                print(line, flush=True)
            if sys.stderr.isatty() or i % 50 == 49:
                done = sum(counts.values())
                print(f"\r{done} loops, {wrong} differ", end="", file=sys.stderr, flush=True)
    print(f"\n{sum(counts.values())} loops, {wrong} figures or reasons differ")
    print(*(f"  {name:24}{count}" for name, count in sorted(counts.items())), sep="\n")
    print("worst of each figure, in parts of what is allowed:")
    print(*(f"  {name:24}{x:.2g}" for name, x in sorted(most.items())), sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

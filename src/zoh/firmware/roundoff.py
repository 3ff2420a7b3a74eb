"""What rounding inside the controller does to the loop: limit cycles and dead band, bounded; noise.

The step's lines are read once more, as sums of states, inputs and errors. floor(a/2^k) is
a/2^k - rho with rho in [0, 1), and what is kept of it (``low``) is 2^k rho, so that this is no
model of rounding but what happens; y is read to half a step. A float operation errs by half a unit
of its last place, of the largest value that it has in a reference step. With h the response from
an error to y in the closed loop, however the errors fall y stays within::

    sum over errors of  |mean sum h| + width/2 sum |h|          (dead band, limit cycles: any)
    sqrt(sum over errors of  width^2/12 sum h^2)                (as noise, standard deviation)

of where it would be without them, as long as no limit is reached.
Source: A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, ch. 6 (quantisation in
the realisation of filters); the bound is the gain from amplitude to amplitude, sum |h|.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.analysis.realised import realised
from zoh.analysis.verify import Verified
from zoh.errors import SpecError
from zoh.firmware.asked import Design
from zoh.firmware.linear import READ, Row, left, rows
from zoh.firmware.lines import Program
from zoh.firmware.plan import Plan
from zoh.lti.frequency_response import FrequencyResponse

Array = npt.NDArray[np.float64]
_BLOCK = 256  # samples whose responses are taken together
_MOST_BLOCKS = 1000
_REST = 1e-9  # of a sum: what one more block adds where it has come to rest
_MOST_DELAY = 500  # samples that are carried as states
_DIGITS = {"f32": 24, "f64": 53}


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundOff:
    """How far rounding moves y and u of the closed loop, in their units.

    y_bound, u_bound  the most, of a dead band or a limit cycle too: of whole numbers whatever the
                      signals are, of floats for values as large as in the design's reference step
    y_noise, u_noise  the standard deviation, where the errors are as good as random
    """

    y_bound: float
    u_bound: float
    y_noise: float
    u_noise: float


def round_off(plan: Plan) -> RoundOff:
    """Return what rounding does to the plan's loop.

    Raises SpecError for a design on a table, which shows no motion, and where the loop has too
    long a memory to be followed.

    >>> import zoh
    >>> from zoh.firmware.plan import plan
    >>> d = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=60)  # kp = 1: y = r
    >>> found = round_off(plan(d, number="q15", y_range=(-1, 1), u_range=(-1, 1)))
    >>> round(found.y_bound * 2**15, 9)  # steps: half of one where y is read, half where u is made
    1.0
    """
    loop = _Loop.of(plan)
    means, widths = loop.errors()
    total, absolute, square = loop.sums()
    bound = np.abs(total @ means) + absolute @ widths / 2
    noise = np.sqrt(square @ (widths * widths) / 12)
    y, u = float(plan.format.y_unit), float(plan.format.u_unit)
    return RoundOff(
        y_bound=float(bound[0]) * y, u_bound=float(bound[1]) * u,
        y_noise=float(noise[0]) * y, u_noise=float(noise[1]) * u,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class _Loop:
    """The closed loop in steps of y and u: state and errors to the next state and to (y, u)."""

    plan: Plan
    errs: Mapping[str, str]  # by the line that makes it
    a: Array
    b: Array  # a column for each error
    c: Array  # rows y and u
    d: Array
    reference: Array  # what r adds to the next state
    values: Array  # every erring line on (state, r)

    @classmethod
    def of(cls, plan: Plan) -> "_Loop":
        """Return the loop of a plan's step and its design's sampled plant."""
        errors = _errors(plan.program)
        found, stores = rows(plan.program, errors), dict(plan.program.step.stores)
        states, columns = list(stores), list(errors.values())
        a_p, b_p, c_p, d_p = _plant(plan)
        n, m = len(states), len(b_p)
        # Z = (controller, plant, r, errors); y = c_p x + d_p u, and u = u_y y + the rest
        at = {name: i for i, name in enumerate([*states, *[""] * m, "r", *columns])}
        size, plant = n + m + 1 + len(columns), slice(n, n + m)

        def on_z(row: Row) -> tuple[Array, float]:
            wide = np.zeros(size)
            for name, c in row.items():
                if name in at:
                    wide[at[name]] = float(c)
            return wide, float(row.get("y", 0))

        rest, u_y = on_z(found[str(plan.program.step.result)])
        y = np.zeros(size)
        y[plant] = c_p
        u = (rest + u_y * y) / (1 - u_y * d_p)
        y = y + d_p * u
        moved = np.zeros((n + m, size))
        for i, state in enumerate(states):
            own, share = on_z(found[stores[state]])
            moved[i] = own + share * y
        moved[plant, plant] = a_p
        moved[plant] += np.outer(b_p, u)
        values = [own + share * y for own, share in (on_z(found[line]) for line in errors)]
        k, err = n + m, slice(n + m + 1, None)
        return cls(
            plan=plan, errs=errors, a=moved[:, :k], b=moved[:, err],
            c=np.array([y[:k], u[:k]]), d=np.array([y[err], u[err]]),
            reference=moved[:, k], values=np.array(values).reshape(-1, size)[:, : k + 1],
        )  # fmt: skip

    def errors(self) -> tuple[Array, Array]:
        """Return the mean and the width of every error."""
        if not self.plan.program.whole:
            return np.zeros(len(self.errs)), self._peaks() * 2.0 ** (1 - _DIGITS[self.plan.number])
        # half a step is added where a sum is rounded: that takes its floor's mean away
        rounded = {x.name for x in self.plan.program.step.lines if x.args[-1] == "half"}
        means = [
            0.0 if error == READ or error.split(" mod ")[0] in rounded else 0.5
            for error in self.errs.values()
        ]
        return np.array(means), np.ones(len(means))

    def _peaks(self) -> Array:
        """Return the largest size of every erring line in the design's reference step."""
        n = len(self.a)
        held = np.zeros((n + 1, n + 1))  # the reference is a state that stays
        held[:n, :n], held[:n, n], held[n, n] = self.a, self.reference, 1.0
        state, peaks = np.append(np.zeros(n), _reference(self.plan.design)), 0.0
        stacked, power = _stacked(self.values, held)
        for _ in range(_MOST_BLOCKS):
            seen = np.abs(stacked @ state).max(axis=0)
            peaks, moved = np.maximum(peaks, seen), power @ state
            if np.abs(moved - state).max() <= _REST * np.abs(moved).max():
                break
            state = moved
        return np.asarray(peaks)

    def sums(self) -> tuple[Array, Array, Array]:
        """Return sum h, sum |h| and sum h^2 over all samples, from every error to y and u."""
        total, absolute, square = self.d.copy(), np.abs(self.d), self.d**2
        stacked, power = _stacked(self.c, self.a)
        state = self.b
        for _ in range(_MOST_BLOCKS):
            h = stacked @ state
            more = np.abs(h).sum(axis=0)
            total, absolute, square = total + h.sum(axis=0), absolute + more, square + (h**2).sum(0)
            if (more <= _REST * absolute + 1e-300).all():
                return total, absolute, square
            state = power @ state
        raise SpecError(
            "plan", f"must have a loop that comes to rest in {_BLOCK * _MOST_BLOCKS} samples",
            self.plan.name, "sample more slowly",
        )  # fmt: skip


def _stacked(rows: Array, a: Array) -> tuple[Array, Array]:
    """Return rows a^i for a block of samples, shape (block, rows, n), and a to a whole block."""
    made = [rows]
    for _ in range(_BLOCK - 1):
        made.append(made[-1] @ a)
    return np.array(made), np.linalg.matrix_power(a, _BLOCK)


def _errors(program: Program) -> dict[str, str]:
    """Return the name of the error that each line makes, by line."""
    lines = program.step.lines
    if program.whole:
        return {"y": READ} | {x.name: left(x) for x in lines if x.op == "asr"}
    rounding = [x for x in lines if x.op in ("add", "sub", "mul")]
    return {x.name: f"error of {x.name}" for x in rounding if not x.name.startswith("guard")}


def _reference(design: Design) -> float:
    assert isinstance(design, Verified)  # as _plant has asked for
    return design.reference


def _plant(plan: Plan) -> tuple[Array, Array, Array, float]:
    """Return the sampled plant from steps of u to steps of y as (A, B, C, D), delays as states."""
    sampled = plan.design.sampled
    if isinstance(sampled, FrequencyResponse):
        raise SpecError("plan", "must rest on a model", "a table", "fit a model to the table")
    if sampled.delay > _MOST_DELAY:
        raise SpecError(
            "plan", f"must have {_MOST_DELAY} samples of delay or fewer", sampled.delay,
            "sample more slowly",
        )  # fmt: skip
    chain, c, d = realised(sampled)
    n, late = len(chain), sampled.delay
    gain = float(plan.format.u_unit / plan.format.y_unit)
    a = np.eye(n + late)
    a[n:, n:] = np.eye(late, k=-1)
    if n:
        a[0, :n] -= chain
        a[1:n, : n - 1] += np.eye(n - 1)
    b, out = np.zeros(n + late), np.zeros(n + late)
    out[:n] = np.array(c) * gain
    if late:
        b[n] = 1.0
        a[0, n + late - 1] += 1.0 if n else 0.0
        out[n + late - 1] = d * gain
        return a, b, out, 0.0
    b[:1] = 1.0 if n else 0.0
    return a, b, out, d * gain

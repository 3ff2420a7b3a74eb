"""The verdicts: each printed number beside the recomputed one.

A verdict is derived. A number that agrees within half a unit of its last printed digit, and a
list of coefficients that also keeps what it stands for, is reproduced; what does not agree
takes verdict and sentence from the finding that explains it, and where there is none says so.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from zoh.app.paper import findings, recipe, table
from zoh.app.paper.findings import Finding
from zoh.app.paper.printed import LAG_IS_CALLED, NUMBERS, Printed, value
from zoh.app.paper.recomputed import Value, recomputed
from zoh.app.paper.study import Study

REPRODUCED, UNEXPLAINED = "reproduced", "unexplained"
LAG_KIND = "lag.kind"

_DENOMINATORS = ("plant.Gd_denominator", "lag.D_den", "pi.D_den", "pid.D_den")


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One printed number or word, beside what the plant gives.

    place    where the paper prints it
    verdict  reproduced, misprint, mislabelled, not-as-claimed, artefact; or unexplained
    why      one sentence where something is to be said, else empty
    """

    id: str
    place: str
    printed: float | str
    recomputed: float | str | None
    verdict: str
    why: str

    def to_dict(self) -> dict[str, float | str | None]:
        """Return the JSON form."""
        return {
            "id": self.id,
            "place": self.place,
            "printed": self.printed,
            "recomputed": self.recomputed,
            "verdict": self.verdict,
            "why": self.why,
        }


def checks(found: Study) -> tuple[Check, ...]:
    """Return a check for every printed number, in the paper's order."""
    values, explained = recomputed(found), findings.by_id(found)
    out = []
    for number in NUMBERS.values():
        if number.id == "lag.phase_margin_deg":
            out.append(_kind(found, explained))
        again = values[number.id]
        if number.id in explained and number.id.startswith("table_1."):
            agrees = _table_agrees(found, number)
            known = explained.get(number.id) if _table_is_twice(number, again) else None
        else:
            agrees = _agrees(number, again) and _keeps_integrators(number.id, values)
            known = explained.get(number.id)
        out.append(verdict(number, again, agrees=agrees, known=known))
    return tuple(out)


def verdict(number: Printed, again: Value, *, agrees: bool, known: Finding | None) -> Check:
    """Return the check of one number; disagreement that nobody explained is said to be that."""
    if agrees:
        word, why = REPRODUCED, known.sentence if known else ""
    elif known:
        word, why = known.verdict, known.sentence
    else:
        word, why = (
            UNEXPLAINED,
            f"Printed is {number.text}, the plant gives {again}: not explained.",
        )
    return Check(
        id=number.id,
        place=number.place,
        printed=number.value,
        recomputed=again,
        verdict=word,
        why=why,
    )


def _agrees(number: Printed, again: Value) -> bool:
    # 1e-12: a value on the edge itself, seen through binary rounding
    return again is not None and abs(again - number.value) <= number.half_unit * (1 + 1e-12)


def _keeps_integrators(number_id: str, values: Mapping[str, Value]) -> bool:
    """Return whether a printed denominator in z still sums to zero where the true one does.

    That sum is its value at z = 1: an integrator is a root there, to the last digit.
    """
    name = number_id.rpartition(".")[0]
    if name not in _DENOMINATORS:
        return True
    listed = [key for key in NUMBERS if key.startswith(name + ".")]
    true = sum(values[key] or 0.0 for key in listed)
    printed = sum(value(key) for key in listed)
    rounding = 1e-12  # of sums of a few doubles near 1
    return abs(true) > rounding or abs(printed) <= rounding


def _table_agrees(found: Study, number: Printed) -> bool:
    """Return whether an entry of Table I is that of the loop that was designed."""
    _, law, metric = number.id.split(".")
    return _agrees(number, table.read_off(found.as_printed)[law][metric])


def _table_is_twice(number: Printed, again: Value) -> bool:
    """Return whether an entry of Table I is explained by the sensor counted twice."""
    return table.near(number.id.rpartition(".")[2], number.value, again)


def _kind(found: Study, explained: Mapping[str, Finding]) -> Check:
    """Return the check of the word: a lag turns the phase back and has its pole first."""
    p, wc = found.recipes["lag"].parameters, value("lag.wc_rad_s")
    turn = recipe.turn_in_w(wc, w0=p["w0"], wp=p["wp"])
    kind, sign = ("phase-lead", "<") if turn > 0 else ("phase-lag", ">=")
    known = explained.get(LAG_KIND)
    agrees = kind == LAG_IS_CALLED
    word = REPRODUCED if agrees else known.verdict if known else UNEXPLAINED
    return Check(
        id=LAG_KIND,
        place="sec. III, title",
        printed=LAG_IS_CALLED,
        recomputed=f"{kind}: w0 {sign} wp, {turn:+.1f} deg at {wc:g} rad/s",
        verdict=word,
        why="" if agrees or known is None else known.sentence,
    )

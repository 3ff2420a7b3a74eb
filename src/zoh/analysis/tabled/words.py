"""What the figures of a table rest on and where they end, one sentence each."""

from collections.abc import Mapping
from math import inf, isfinite, log10

from zoh.analysis.tabled.count import Count
from zoh.analysis.tabled.path import Path
from zoh.analysis.tabled.results import Beyond, Spread
from zoh.analysis.tabled.spread import Figures

_ONCE = {
    "interpolation": "between its points the table is joined by a curve; without every second "
    "point {} would move by {}: a resonance narrower than the spacing is not seen at all",
    "noise": "1 sigma of the points is, to first order, 1 sigma of {}: {}",
    "neglected": "what the values leave out moves {}, to first order, by at most {}",
}


def warnings(
    path: Path, seen: Figures, verdict: Count, outside: Beyond,
    spreads: Mapping[str, Spread | None],
) -> tuple[str, ...]:  # fmt: skip
    """Return every sentence that belongs to these figures."""
    if verdict.unstable is None:
        said = [f"the table does not decide stability: {verdict.why}"]
    elif verdict.hidden:
        granted = f"; taken for granted: {verdict.why}" if verdict.why else ""
        said = [f"a hidden mode keeps the closed loop unstable, {verdict.hidden}{granted}"]
    else:
        said = [f"stability is counted on the table; taken for granted: {verdict.why}"]
    said.append(_edges(path, outside))
    if seen.crossover is None:
        said.append("no gain crossing in the table: a phase margin is not known")
    if seen.phase_crossover is None:
        bound = _db(outside.gain_margin)
        said.append(f"no phase crossing in the table: the gain margin given, {bound}, is a bound")
    for name, value in spreads.items():
        if value is not None:
            said.append(_ONCE[name].format("PM, GM and Ms", _amounts(value)))
    if spreads["interpolation"] is None:
        said.append("the table is too short to tell what lies between its points")
    said += _turns(path)
    if path.low is None:
        first = f"{path.table.band[0]:.6g} rad/s"
        said.append(
            f"the low end does not say |T| at 0: the bandwidth is counted from it at {first}"
        )
    return tuple(said)


def _edges(path: Path, outside: Beyond) -> str:
    low, high = path.table.band
    text = f"crossings below {low:.6g} and above {high:.6g} rad/s are not seen"
    if path.table.reaches_nyquist:
        text = f"crossings below {low:.6g} rad/s are not seen"
    if outside.ms == inf:
        return f"{text}, and nothing bounds what is there"
    return (
        f"{text}; granted the same, none has a gain margin nearer to 0 than "
        f"{_db(outside.gain_margin)}, and Ms is at most {outside.ms:.4g} there"
    )


def _turns(path: Path) -> list[str]:
    """Return a sentence on turns of the phase that may have gone the other way."""
    places = [f"{path.table.w[i]:.6g} to {path.table.w[i + 1]:.6g}" for i in path.table.ambiguous]
    if not places:
        return []
    more = f" and {len(places) - 3} more" if len(places) > 3 else ""
    return [
        f"the phase turns by more than 120 deg from one point to the next ({', '.join(places[:3])}"
        f"{more} rad/s): it is taken the shorter way round, and may have gone the other"
    ]


def _amounts(spread: Spread) -> str:
    rows = ((spread.phase_margin_deg, "deg"), (spread.gain_margin_db, "dB"), (spread.ms, ""))
    return ", ".join(
        "none" if x is None else f"{x:.2g} {unit}".strip() if isfinite(x) else "an unknown amount"
        for x, unit in rows
    )


def _db(factor: float) -> str:
    return f"{20 * log10(factor):.4g} dB" if 0 < factor < inf else f"{factor:g}"

"""Measured designs as text: numbers, transfer functions and tables in Markdown."""

from collections.abc import Iterable, Mapping, Sequence
from math import ceil, floor, inf, log10

from zoh.analysis.results import Margins, StepInfo
from zoh.analysis.tabled.verify import Evidence, TableMeasured
from zoh.lti import written
from zoh.lti.poly import trim
from zoh.lti.systems import Sampled
from zoh.lti.written import fraction

NOTHING = "-"  # a quantity that does not exist
_VERDICTS = {True: "stable", False: "**unstable**", None: "**not decided**"}


def design_table(results: Sequence[Evidence]) -> str:
    """Return the comparison as a Markdown table, one column per design."""
    rows = zip(*(facts(d).items() for d in results), strict=True)
    head = ["", *(cell(d.name) for d in results)]
    return table(head, [[row[0][0], *(value for _, value in row)] for row in rows])


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["a", "b"], [["1", "2"]]))
    | a | b |
    | --- | --- |
    | 1 | 2 |
    """
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def in_z(system: Sampled, digits: int | None = None) -> str:
    """Return D(z) as text, every digit unless told: near z = 1 the last ones are the design.

    >>> in_z(Sampled(num=[5.839, -5.823], den=[1, -1], dt=0.1))
    '(5.839 z - 5.823)/(z - 1)'
    """
    return fraction(system.num, system.den, "z", digits)


def in_w(system: Sampled, digits: int = 6) -> str:
    """Return D(w) as text, the first coefficient of its denominator 1.

    >>> in_w(Sampled(num=[1.0, 1.0], den=[1.0, -1.0], dt=2.0))
    '1/w'
    """
    num, den = trim(system.num_w), trim(system.den_w)
    text = fraction([c / den[0] for c in num], [c / den[0] for c in den], "w", digits)
    return text if not system.delay else f"z^-{system.delay} {text}"


def number(value: float | None, digits: int = 4) -> str:
    """Return a value for a person to read: no more digits than asked, infinity as ∞.

    >>> number(2.88961, 3), number(inf), number(None), number(-0.0)
    ('2.89', '∞', '-', '0')
    """
    if value is None:
        return NOTHING
    if value == inf:
        return "∞"
    return f"{value or 0.0:.{digits}g}"  # no minus before a zero


def cell(text: str) -> str:
    """Return user text that cannot leave its table cell."""
    return " ".join(text.replace("|", "\\|").split())


def slug(name: str, taken: Iterable[str] = ()) -> str:
    """Return a file name of letters, digits and dashes, different from those taken.

    >>> slug("PID, 40 deg"), slug("../x", ["x"])
    ('pid-40-deg', 'x-2')
    """
    plain = "".join(c if c.isascii() and c.isalnum() else " " for c in name.lower())
    base = "-".join(plain.split()) or "design"
    used, k, out = set(taken), 1, base
    while out in used:
        k += 1
        out = f"{base}-{k}"
    return out


def horizon(steps: Iterable[StepInfo | None]) -> float:
    """Return seconds that show every response settle, rounded up to two digits, the second even."""
    known = [s.settling_time for s in steps if s is not None and s.settling_time]
    longest = 1.3 * max(known, default=1.0)
    unit = float(10.0 ** floor(log10(longest))) / 5
    return ceil(longest / unit) * unit


def _output_effort(d: Evidence) -> Mapping[str, str]:
    """Return the effort where the reference counts output units, if those differ."""
    if isinstance(d, TableMeasured) or d.plant.sensor == 1:
        return {}
    effort = d.step.peak_effort if d.step else None
    scaled = None if effort is None else effort * abs(d.plant.sensor)
    return {"effort, r in output units": number(scaled, 3)}


def _settling(s: StepInfo | None) -> str:
    """Return the settling time, or why there is none."""
    if s is None or s.settling_time is not None or not s.final_value:
        return number(s.settling_time if s else None, 3)
    return s.settling


def _proof(m: Margins) -> str:
    """Return whether it is proved that nothing was missed."""
    if m.certificate is None:
        return "as the table shows"
    return "proved" if m.certificate.holds else f"not proved: {', '.join(m.certificate.open())}"


def facts(d: Evidence) -> Mapping[str, str]:
    """Return every row of the comparison for one design."""
    m, s = d.margins, d.step
    between = s.between_samples if s is not None else None
    gains = ", ".join(f"{k} = {written.number(v)}" for k, v in d.gains.items())
    return {
        "law": cell(d.law),
        "gains": cell(gains) or NOTHING,
        "D(z)": in_z(d.controller),
        "D(w)": in_w(d.controller),
        "closed loop": _VERDICTS[m.stable],
        "crossover, rad/s": number(m.crossover),
        "phase margin, deg": number(m.phase_margin_deg),
        "gain margin, dB": number(m.gain_margin_db),
        "delay margin, s": number(m.delay_margin),
        "Ms": number(m.ms),
        "bandwidth, rad/s": number(m.bandwidth),
        "crossings and peaks": _proof(m),
        "overshoot at the samples, %": number(s.overshoot_pct if s else None, 3),
        "overshoot between them, %": number(between.overshoot_pct if between else None, 3),
        "rise time, s": number(s.rise_time if s else None, 3),
        "settling time, s": _settling(s),
        "steady-state error": number(s.steady_state_error if s else None, 3),
        "peak effort": number(s.peak_effort if s else None, 3),
        **_output_effort(d),
        "requirements": "met" if d.met else "**missed**",
    }

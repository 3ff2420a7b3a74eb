"""What was asked against what was measured."""

from zoh.analysis.results import Margins, StepInfo
from zoh.spec import Requirements

_EQUAL = 1e-9  # 6 x 0.1 s is 0.6000000000000001: what equals a bound but for rounding meets it


def missed(asked: Requirements, margins: Margins, step: StepInfo | None) -> list[str]:
    """Return a sentence for each requirement missed, instability first."""
    if not margins.stable:
        return ["the closed loop is unstable"]
    found = []
    for name, bound, value, at_least in _compared(asked, margins, step):
        if bound is None:
            continue
        slack = _EQUAL * abs(bound)
        good = value is not None and (
            value >= bound - slack if at_least else value <= bound + slack
        )
        if not good:
            word = "at least" if at_least else "at most"
            shown = "none" if value is None else f"{value:.6g}"
            found.append(f"{name} must be {word} {bound:g}, measured {shown}")
    return found


def _compared(
    asked: Requirements, margins: Margins, step: StepInfo | None
) -> list[tuple[str, float | None, float | None, bool]]:
    """Return (name, bound, measured, whether the bound is a least) for every requirement."""
    gain_db = abs(margins.gain_margin_db)
    rows: list[tuple[str, float | None, float | None, bool]] = [
        ("pm_deg", asked.pm_deg, margins.phase_margin_deg, True),
        ("gain_margin_db", asked.gain_margin_db, gain_db, True),
        ("delay_margin", asked.delay_margin, margins.delay_margin, True),
        ("ms", asked.ms, margins.ms, False),
        ("mt", asked.mt, margins.mt, False),
    ]
    if step is not None:
        between = step.between_samples or step
        error = None if step.steady_state_error is None else abs(step.steady_state_error)
        rows += [
            ("overshoot_pct", asked.overshoot_pct, between.overshoot_pct, False),
            ("rise_time", asked.rise_time, step.rise_time, False),
            ("settling_time", asked.settling_time, step.settling_time, False),
            ("steady_state_error", asked.steady_state_error, error, False),
            ("peak_effort", asked.peak_effort, step.peak_effort, False),
        ]
    return rows

"""The header of a plan: the interface, and everything that was verified, in one comment."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from zoh.analysis.results import Margins, StepInfo
from zoh.analysis.tabled.results import TableMargins
from zoh.errors import SpecError
from zoh.firmware.book import IO_BITS
from zoh.firmware.plan import Plan
from zoh.firmware.roundoff import round_off
from zoh.firmware.words import float_literal, result_type, state_type
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.written import fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """What a step costs on a processor, measured.

    target        such as "Cortex-M4F -O2"
    instructions  least, mean and most, executed per sample
    code_bytes    of the code with constants and software arithmetic, without the self-test
    stack_bytes   what a step takes of the stack, None where not measured
    """

    target: str
    instructions: tuple[int, float, int]
    code_bytes: int
    stack_bytes: int | None = None


def header(plan: Plan, costs: Sequence[Cost]) -> str:
    """Return the text of NAME.h."""
    name, kind, guard = plan.name, result_type(plan.number), f"{plan.name.upper()}_H"
    lines = [*_design(plan), "", *_numbers(plan), "", *_use(plan), "", *_cost(costs)]
    inside = (line.replace("*/", "* /").replace("/*", "/ *") for line in lines)
    comment = "\n".join(f" * {line}".rstrip() for line in inside)
    return (
        f"/*\n{comment}\n */\n#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n"
        f'#ifdef __cplusplus\nextern "C" {{\n#endif\n\n'
        f"#define {name.upper()}_DT {_seconds(plan)} /* s, from call to call of step */\n\n"
        f"typedef struct {{\n{_members(plan)}}} {name}_state;\n\n"
        f"void {name}_init({name}_state *s);\n"
        f"void {name}_reset({name}_state *s, {kind} u0);\n"
        f"{kind} {name}_step({name}_state *s, {kind} r, {kind} y, {kind} ff);\n"
        f"void {name}_track({name}_state *s, {kind} r, {kind} y, {kind} ff, {kind} u_manual);\n"
        f"int32_t {name}_selftest(void);\n\n"
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )


def _seconds(plan: Plan) -> str:
    return f"{float_literal(plan.dt, 'f64')}"


def _members(plan: Plan) -> str:
    kind = state_type(plan.number)
    text = "".join(f"    {kind} {s.name}; /* {s.says} */\n" for s in plan.program.states)
    if not plan.program.whole:
        counter = "uint32_t" if plan.number == "f32" else "uint64_t"
        text += f"    {counter} faults; /* samples that were not finite, and not used */\n"
    return text


def _design(plan: Plan) -> list[str]:
    d = plan.design
    gains = ", ".join(f"{k} = {v:.9g}" for k, v in d.gains.items())
    return [
        f"{plan.name}: {d.law} controller" + (f", {gains}" if gains else ""),
        f"sha-256  {plan.sha256}",
        f"plant    {_written(plan)}",
        f"clock    dt = {plan.dt:.9g} s, compute delay {d.compute_delay:.9g} s",
        f"design   {_margins(d.margins)}",
        f"as built {_margins(plan.quantised.margins)}",
        *_step(d.step, plan.quantised.step),
        _rounding(plan),
        *plan.said,
    ]


def _written(plan: Plan) -> str:
    plant = plan.design.plant
    if isinstance(plant, FrequencyResponse):
        low, high = plant.band
        return f"a table of {len(plant.w)} measured points, {low:.6g} to {high:.6g} rad/s"
    text = fraction(plant.num, plant.den, "s")
    text += f", dead time {plant.dead_time:.9g} s" if plant.dead_time else ""
    return text + (f", sensor {plant.sensor:.9g}" if plant.sensor != 1 else "")


def _margins(m: Margins | TableMargins) -> str:
    wc = "no crossover" if m.crossover is None else f"at {m.crossover:.6g} rad/s"
    return (
        f"phase margin {m.phase_margin_deg:.6g} deg {wc}, gain margin {m.gain_margin_db:.4g} dB, "
        f"delay margin {m.delay_margin:.4g} s, Ms {m.ms:.5g}"
    )


def _step(design: StepInfo | None, built: StepInfo | None) -> list[str]:
    if design is None or built is None or design.overshoot_pct is None:
        return []
    return [
        f"step     designed: overshoot {design.overshoot_pct:.5g} %, settling {design.settling}; "
        f"built: {built.overshoot_pct:.5g} %, {built.settling}"
    ]


def _rounding(plan: Plan) -> str:
    try:
        found = round_off(plan)
    except SpecError as refused:
        return f"rounding not bounded: {refused}"
    while_ = "" if plan.program.whole else "in the reference step "
    return (
        f"rounding moves y {while_}by {found.y_bound:.3g} at most (dead band and limit cycles "
        f"included), as long as no limit is reached, as noise by {found.y_noise:.2g}, "
        f"u by {found.u_noise:.2g}"
    )


def _numbers(plan: Plan) -> list[str]:
    f = plan.features
    each = [_limit(plan, "u_min"), _limit(plan, "u_max")]
    each += ["" if f.change is None else f"at most {float(f.change):.9g} a sample"]
    limits = ", ".join(x for x in each if x) or "no limits"
    if plan.number not in IO_BITS:
        return [
            f"numbers  {result_type(plan.number)}, {plan.realisation}; {limits}",
            "a sample that makes anything infinite or not a number is not used: the states stay,",
            "the last output is returned, faults counts it",
        ]
    half = 1 << IO_BITS[plan.number] - 1
    ranges = plan.ranges.states if plan.ranges else {}
    states = [f"         {n}: {low} ... {high}" for n, (low, high) in ranges.items()]
    return [
        f"numbers  {plan.number}, {plan.realisation}: r and y count "
        f"{float(plan.format.y_unit):.9g}, u and ff {float(plan.format.u_unit):.9g} a step;",
        f"         {half} of them are {float(plan.format.y_unit * half):.9g} "
        f"and {float(plan.format.u_unit * half):.9g}; {limits}",
        "no value overflows, whatever the inputs and for all time; states within",
        *states,
    ]


def _limit(plan: Plan, name: str) -> str:
    """Return a limit as it is built; one that is where the numbers end is said to be."""
    asked: Fraction | None = getattr(plan.features, name)
    if asked is None:
        return ""
    built, form = plan.program.value(name), plan.format
    if not form.whole:
        return f"{name} {built:.9g}"
    ends = " (where its numbers end)" if built in (form.least, form.most) else ""
    return f"{name} {float(built * form.u_unit):.9g}{ends}"


def _use(plan: Plan) -> list[str]:
    n = plan.name
    return [
        f"use      {n}_init once; {n}_step every dt with reference, measurement and a feed-",
        f"         forward, 0 where there is none; {n}_track instead while another sets u;",
        *(
            []
            if plan.holds_u
            else ["         the step after it may jump: no integral could hold u;"]
        ),
        f"         {n}_selftest is 0 if compiler and processor compute what was verified",
    ]


def _cost(costs: Sequence[Cost]) -> list[str]:
    if not costs:
        return ["cost     not measured; zoh.prove measures it on emulated processors"]
    lines = ["cost     instructions a sample (least, mean, most), bytes of code, bytes of stack"]
    for c in costs:
        low, mean, high = c.instructions
        stack = "-" if c.stack_bytes is None else str(c.stack_bytes)
        lines.append(f"         {c.target}: {low}, {mean:.1f}, {high}; {c.code_bytes}; {stack}")
    return lines

"""How a controller is wired to a board: an Arduino sketch and the same for the STM32 HAL.

Both are examples that compile as they stand. What a board must be told, which pins, and which count
of a converter is which value, is marked in them. They keep time in whole microseconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from zoh.firmware.book import IO_BITS
from zoh.firmware.plan import Plan
from zoh.firmware.words import float_literal, result_type
from zoh.sampling.hold import whole_samples

_SAYS = "the design counts {:.9g} s from measuring to putting out"
_DAC = "&hdac, DAC_CHANNEL_1, DAC_ALIGN_12B_R"
_OFF = 1e-3  # of a period: by more the clock of an example may not be off

_SKETCH = """\
/* {name}_arduino.ino: {name} on an Arduino. Put this file, {name}.h and {name}.c into a folder
 * called {name}_arduino. Look through what is marked YOURS before power is on. */
#include "{name}.h"

static const uint8_t REFERENCE_PIN = A0; /* YOURS: the pins */
static const uint8_t MEASUREMENT_PIN = A1;
static const uint8_t OUTPUT_PIN = 9;
static const uint32_t PERIOD_US = {period}UL; /* {name_upper}_DT */

static {name}_state controller;
static uint32_t due;
{kept}
{conversions}
void setup(void)
{{
    if ({name}_selftest() != 0) {{
        for (;;) {{ /* this board does not compute what was verified: it must not drive anything */
        }}
    }}
    {name}_init(&controller);
    due = micros();
}}

void loop(void)
{{
    if ((int32_t)(micros() - due) < 0) {{
        return;
    }}
    due += PERIOD_US;
{before}    const {kind} y = measured(analogRead(MEASUREMENT_PIN));
    const {kind} r = measured(analogRead(REFERENCE_PIN));
    const {kind} u = {name}_step(&controller, r, y, {zero});
{after}}}
"""

_HAL = """\
/* {name}_stm32.c: {name} in a timer's interrupt, for a project made by STM32CubeMX. Set a timer
 * that counts microseconds to {period} of them, one converter and one output to 12 bits. Look
 * through what is marked YOURS. */
#include "main.h"
#include "{name}.h"

extern TIM_HandleTypeDef htim6; /* YOURS: the timer, the converter, the output */
extern ADC_HandleTypeDef hadc1;
extern DAC_HandleTypeDef hdac;

void {name}_start(void);

volatile {kind} {name}_reference = {zero}; /* set by the rest of the program */
static {name}_state controller;
{kept}
{conversions}
/* Call this once, after CubeMX has set everything up. */
void {name}_start(void)
{{
    if ({name}_selftest() != 0) {{
        Error_Handler(); /* this board does not compute what was verified */
    }}
    {name}_init(&controller);
    (void)HAL_DAC_Start(&hdac, DAC_CHANNEL_1);
    (void)HAL_TIM_Base_Start_IT(&htim6);
}}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim)
{{
    if (htim->Instance == TIM6) {{
{before}        (void)HAL_ADC_Start(&hadc1);
        (void)HAL_ADC_PollForConversion(&hadc1, 1U);
        const {kind} y = measured((int32_t)HAL_ADC_GetValue(&hadc1));
        const {kind} u = {name}_step(&controller, {name}_reference, y, {zero});
{after}    }}
}}
"""


def arduino(plan: Plan) -> str:
    """Return a sketch for a board with a converter of 10 bits and pulses of 8."""
    conversions = _measured(plan, 10, "int") + "\n" + _driven(plan, 8, "int")
    put_out = _PutOut(
        write="analogWrite(OUTPUT_PIN, driven({}));",
        since="(uint32_t)(micros() - (due - PERIOD_US))", indent=4,
    )  # fmt: skip
    return _SKETCH.format(**_words(plan), **put_out.words(plan), conversions=conversions)


def stm32(plan: Plan) -> str:
    """Return a timer's interrupt for the STM32 HAL, converters of 12 bits."""
    conversions = _measured(plan, 12, "int32_t") + "\n" + _driven(plan, 12, "int32_t")
    put_out = _PutOut(
        write=f"(void)HAL_DAC_SetValue({_DAC}, (uint32_t)driven({{}}));",
        since="__HAL_TIM_GET_COUNTER(htim)", indent=8,
    )  # fmt: skip
    return _HAL.format(**_words(plan), **put_out.words(plan), conversions=conversions)


@dataclass(frozen=True, slots=True, kw_only=True)
class _PutOut:
    """How an output is put out when the design counts it to be: samples and a part of one later.

    write  the statement, {} in it for u;  since  us since the measurement;  indent  of the lines
    """

    write: str
    since: str
    indent: int

    def words(self, plan: Plan) -> dict[str, str]:
        """Return what is kept, and what is done before the measurement and after the step."""
        delay, kind = plan.design.compute_delay, result_type(plan.number)
        late, early = whole_samples(0.0, delay, plan.dt)
        samples = late - 1 if early else late
        wait = round((delay - samples * plan.dt) * 1e6) if early else 0
        then = self.write.format("pending[0]" if samples else "u")
        kept = [f"/* {_SAYS.format(delay)}. */"] if delay else []
        kept += [f"static {kind} pending[{samples}]; /* outputs on their way */"] if samples else []
        kept += [f"static const uint32_t WAIT_US = {wait}UL;"] if wait else []
        waits = [f"while ({self.since} < WAIT_US) {{", "}"] if wait else []
        at_once = bool(samples and not wait)  # before a new measurement
        return {
            "kept": "".join(f"{line}\n" for line in kept),
            "before": self._set([then]) if at_once else "",
            "after": self._set([*waits, *([] if at_once else [then]), *_moved(samples)]),
        }

    def _set(self, lines: Sequence[str]) -> str:
        return "".join(f"{' ' * self.indent}{line}\n" for line in lines)


def _moved(samples: int) -> list[str]:
    """Return the lines that move the outputs on their way by one sample."""
    if samples < 2:
        return ["pending[0] = u;"] * samples
    last = samples - 1
    loop = f"for (uint32_t k = 0U; k < {last}U; k++) {{"
    return [loop, "    pending[k] = pending[k + 1U];", "}", f"pending[{last}] = u;"]


def examples(plan: Plan) -> dict[str, str]:
    """Return the examples by file name; none for a clock that no microsecond counter keeps."""
    exact = plan.dt * 1e6
    if not 1e-6 <= plan.dt <= 2000.0 or abs(round(exact) - exact) > _OFF * exact:
        return {}
    return {f"{plan.name}_arduino.ino": arduino(plan), f"{plan.name}_stm32.c": stm32(plan)}


def _words(plan: Plan) -> dict[str, str]:
    return {
        "name": plan.name,
        "name_upper": plan.name.upper(),
        "kind": result_type(plan.number),
        "zero": _number(plan, 0.0),
        "period": str(round(plan.dt * 1e6)),
    }


def _measured(plan: Plan, bits: int, count: str) -> str:
    """Return the C that makes r and y of a converter's count: its step is a 2^bits-th of its span.

    The ends are those of y_range, -1 and 1 where none was given.
    """
    kind, counts = result_type(plan.number), 1 << bits
    low, high = plan.y_range or (-1.0, 1.0)
    head = f"/* YOURS: what the controller compares at count 0 of the converter, and at {counts}"
    function = f"static {kind} measured({count} count)\n{{\n"
    if not plan.format.whole:
        return (
            f"{head}. */\n"
            f"static const {kind} Y_LOW = {_number(plan, low)};\n"
            f"static const {kind} Y_HIGH = {_number(plan, high)};\n\n"
            f"{function}    return Y_LOW + (({kind})count * ((Y_HIGH - Y_LOW) / "
            f"{_number(plan, counts)}));\n}}\n"
        )
    wide, unit = _wide(plan), plan.format.y_unit
    ends = [round(Fraction(end) / unit) for end in (low, high)]
    return (
        f"{head}, in steps of {float(unit):.6g}:\n * here {low:.6g} and {high:.6g}. */\n"
        f"static const {wide} Y_LOW = {_whole(ends[0])};\n"
        f"static const {wide} Y_HIGH = {_whole(ends[1])};\n\n"
        f"{function}    return ({kind})(Y_LOW + ((({wide})count * (Y_HIGH - Y_LOW)) / {counts}));\n"
        "}\n"
    )


def _driven(plan: Plan, bits: int, count: str) -> str:
    """Return the C that makes an output's count of u, whose limits are the ends of the output."""
    kind, most = result_type(plan.number), (1 << bits) - 1
    head = f"/* YOURS: the u that is 0 at the output, and the u that is {most}"
    function = f"static {count} driven({kind} u)\n{{\n"
    if plan.format.whole:
        wide, unit = _wide(plan), float(plan.format.u_unit)
        low, high = (int(plan.program.value(name)) for name in ("u_min", "u_max"))
        return (
            f"{head}, in steps of {unit:.6g}:\n * here {low * unit:.6g} and {high * unit:.6g}. */\n"
            f"static const {wide} U_LOW = {_whole(low)};\n"
            f"static const {wide} U_HIGH = {_whole(high)};\n\n"
            f"{function}    const {wide} span = U_HIGH - U_LOW;\n"
            f"    const {wide} share = (((({wide})u - U_LOW) * {most}) + (span / 2)) / span;\n"
            f"    const {wide} kept = (share > {most}) ? {most} : share;\n"
            f"    return (kept > 0) ? ({count})kept : 0;\n}}\n"
        )
    ends = (plan.features.u_min, plan.features.u_max)
    shut, full = (d if e is None else float(e) for d, e in zip((-1.0, 1.0), ends, strict=True))
    one, none, half = (_number(plan, x) for x in (1.0, 0.0, 0.5))
    return (
        f"{head}. */\n"
        f"static const {kind} U_LOW = {_number(plan, shut)};\n"
        f"static const {kind} U_HIGH = {_number(plan, full)};\n\n"
        f"{function}    const {kind} share = (u - U_LOW) / (U_HIGH - U_LOW);\n"
        f"    const {kind} kept = (share > {one}) ? {one} : share;\n"
        f"    return (kept > {none}) ? ({count})((kept * {_number(plan, most)}) + {half}) : 0;\n"
        "}\n"
    )


def _wide(plan: Plan) -> str:
    """Return the C type that holds a number of the format times a converter's count."""
    return "int32_t" if IO_BITS[plan.number] == 16 else "int64_t"


def _whole(value: int) -> str:
    """Return a whole number as C writes it; of more than 31 bits it has its suffix."""
    return str(value) if abs(value) < 1 << 31 else f"{value}LL"


def _number(plan: Plan, value: float) -> str:
    """Return a value in the controller's own type."""
    if plan.format.whole:
        return str(round(value))
    held = float(np.float32(value)) if plan.number == "f32" else float(value)
    return float_literal(held, plan.number)

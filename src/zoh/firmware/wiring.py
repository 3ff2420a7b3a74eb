"""How a controller is wired to a board: an Arduino sketch and the same for the STM32 HAL.

Both are examples that compile as they stand. What a board must be told, which pins, and which count
of a converter is which value, is marked in them. They keep time in whole microseconds.
"""

import numpy as np

from zoh.firmware.book import IO_BITS
from zoh.firmware.plan import Plan
from zoh.firmware.words import float_literal, result_type

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
    const {kind} y = measured(analogRead(MEASUREMENT_PIN));
    const {kind} r = measured(analogRead(REFERENCE_PIN));
    analogWrite(OUTPUT_PIN, driven({name}_step(&controller, r, y, {zero})));
}}
"""

_HAL = """\
/* {name}_stm32.c: {name} in a timer's interrupt, for a project made by STM32CubeMX. Set a basic
 * timer to {period} us, one converter to 12 bits, one output to 12 bits. Look through what is
 * marked YOURS. */
#include "main.h"
#include "{name}.h"

extern TIM_HandleTypeDef htim6; /* YOURS: the timer, the converter, the output */
extern ADC_HandleTypeDef hadc1;
extern DAC_HandleTypeDef hdac;

void {name}_start(void);

volatile {kind} {name}_reference = {zero}; /* set by the rest of the program */
static {name}_state controller;

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
        (void)HAL_ADC_Start(&hadc1);
        (void)HAL_ADC_PollForConversion(&hadc1, 1U);
        const {kind} y = measured((int32_t)HAL_ADC_GetValue(&hadc1));
        const {kind} u = {name}_step(&controller, {name}_reference, y, {zero});
        (void)HAL_DAC_SetValue(&hdac, DAC_CHANNEL_1, DAC_ALIGN_12B_R, (uint32_t)driven(u));
    }}
}}
"""


def arduino(plan: Plan) -> str:
    """Return a sketch for a board with a converter of 10 bits and pulses of 8."""
    conversions = _measured(plan, 10, "int") + "\n" + _driven(plan, 8, "int")
    return _SKETCH.format(**_words(plan), conversions=conversions)


def stm32(plan: Plan) -> str:
    """Return a timer's interrupt for the STM32 HAL, converters of 12 bits."""
    conversions = _measured(plan, 12, "int32_t") + "\n" + _driven(plan, 12, "int32_t")
    return _HAL.format(**_words(plan), conversions=conversions)


def examples(plan: Plan) -> dict[str, str]:
    """Return the examples by file name; none for a clock that no microsecond counter keeps."""
    if not 1e-6 <= plan.dt <= 2000.0:
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
    """Return the C that makes r and y of a converter's count."""
    kind, middle = result_type(plan.number), 1 << bits - 1
    head = f"static {kind} measured({count} count)\n{{\n"
    if plan.format.whole:
        scale = 1 << IO_BITS[plan.number] - bits
        ends = float(plan.format.y_unit) * (1 << IO_BITS[plan.number] - 1)
        return (
            f"/* YOURS: 0 ... {2 * middle - 1} are -{ends:.6g} ... {ends:.6g} of what the "
            "controller compares. */\n"
            f"{head}    return ({kind})(((int32_t)count - {middle}) * {scale});\n}}\n"
        )
    return (
        f"/* YOURS: what the controller compares, per count of the converter from {middle}. */\n"
        f"static const {kind} UNITS_PER_COUNT = {_number(plan, 1 / middle)};\n\n"
        f"{head}    return UNITS_PER_COUNT * ({kind})(count - {middle});\n}}\n"
    )


def _driven(plan: Plan, bits: int, count: str) -> str:
    """Return the C that makes an output's count of u."""
    kind, most = result_type(plan.number), (1 << bits) - 1
    head = f"static {count} driven({kind} u)\n{{\n"
    if plan.format.whole:
        steps = 1 << IO_BITS[plan.number] - bits
        ends = float(plan.format.u_unit) * (1 << IO_BITS[plan.number] - 1)
        return (
            f"/* YOURS: -{ends:.6g} ... {ends:.6g} of u are 0 ... {most} of the output. */\n"
            f"{head}    return ({count})(u / {steps}) + {1 << bits - 1};\n}}\n"
        )
    low, high = plan.features.u_min, plan.features.u_max
    shut, full = -1.0 if low is None else float(low), 1.0 if high is None else float(high)
    return (
        f"/* YOURS: the u that is 0 and the u that is {most} at the output. */\n"
        f"static const {kind} U_LOW = {_number(plan, shut)};\n"
        f"static const {kind} U_HIGH = {_number(plan, full)};\n\n"
        f"{head}    const {kind} share = (u - U_LOW) / (U_HIGH - U_LOW);\n"
        f"    const {kind} kept = (share > {_number(plan, 1.0)}) ? {_number(plan, 1.0)} : share;\n"
        f"    return (kept > {_number(plan, 0.0)}) ? ({count})(kept * {_number(plan, most)}) : 0;\n"
        "}\n"
    )


def _number(plan: Plan, value: float) -> str:
    """Return a value in the controller's own type."""
    if plan.format.whole:
        return str(round(value))
    held = float(np.float32(value)) if plan.number == "f32" else float(value)
    return float_literal(held, plan.number)

"""Around the controller: a README, a sketch for Arduino boards and an example for STM32's HAL.

What they read and drive is a guess that a person must replace, and says so; when they do it is not.
"""

import numpy as np

from zoh.firmware.book import IO_BITS
from zoh.firmware.plan import Plan
from zoh.firmware.words import float_literal, result_type

_ADAPT = "adapt: "


def wiring(plan: Plan) -> dict[str, str]:
    """Return README.md, NAME.ino and NAME_stm32.c by file name, beside what ``c.emit`` gives.

    >>> import zoh
    >>> from zoh.firmware.plan import plan
    >>> d = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> sorted(wiring(plan(d, name="loop", u_min=-1, u_max=1)))
    ['README.md', 'loop.ino', 'loop_stm32.c']
    """
    return {
        "README.md": _readme(plan),
        f"{plan.name}.ino": _arduino(plan),
        f"{plan.name}_stm32.c": _stm32(plan),
    }


def _period_us(plan: Plan) -> int:
    return max(1, round(plan.dt * 1e6))


def _units(plan: Plan) -> str:
    if plan.number not in IO_BITS:
        return (
            "`r` and `y` are in the units that the controller compares, `u` and `ff` in the "
            "plant input's."
        )
    return (
        f"`r` and `y` are whole numbers of {float(plan.format.y_unit):.9g}, `u` and `ff` of "
        f"{float(plan.format.u_unit):.9g}, in physical units; a value beyond the format must be "
        "limited before it is given."
    )


def _readme(plan: Plan) -> str:
    n, kind = plan.name, result_type(plan.number)
    loss = plan.pm_loss_deg
    return f"""\
# {n}

`{n}.c` and `{n}.h` are one digital controller ({plan.design.law}, {plan.number}, {plan.realisation}
form), generated from a verified design; do not edit them. The header says what was verified.
Rounding to {plan.number} has moved the phase margin by {loss:.3g} deg.

## Into a timer interrupt

    #include "{n}.h"

    static {n}_state state;                     /* zero is no state: call init */

    void start(void)
    {{
        {n}_init(&state);
        if ({n}_selftest() != 0) {{ stop(); }}     /* this compiler computes something else */
        /* then start a timer that fires every {plan.dt:.9g} s */
    }}

    void timer_interrupt(void)                  /* the highest priority that you can give it */
    {{
        const {kind} y = measure();
        actuate({n}_step(&state, reference, y, 0));
    }}

- {_units(plan)}
- Call `{n}_step` every {plan.dt:.9g} s exactly: the design is for this clock. From `measure` to
  `actuate` a delay of {plan.design.compute_delay:.9g} s is counted in the margins.
- While somebody else sets the output, call `{n}_track(&state, r, y, u)` instead, every sample; the
  next `{n}_step` goes on from there without a bump.
- `{n}_reset(&state, u0)` puts it to rest at the output u0.
- One state is one loop: nothing is shared, so that one controller may run many loops. A state must
  not be used by two interrupts at once.
- Compile with any options but `-ffast-math`; the source refuses that, and keeps operations from
  being fused. C99 or later, C++17.

`{n}.ino` and `{n}_stm32.c` are examples: replace what is marked `{_ADAPT.strip()}`.
"""


def _literals(plan: Plan) -> dict[str, str]:
    """Return the C of a conversion from 0 ... 1 to y, and from u to 0 ... 1."""
    if plan.number in IO_BITS:
        shift = IO_BITS[plan.number] - 12
        low = plan.program.value("u_min")
        high = plan.program.value("u_max")
        kind = result_type(plan.number)
        return {
            "y": f"({kind})((int32_t)(raw - 2048) * {1 << shift})",
            "duty": f"(uint32_t)((((int64_t)u - ({low})) * 4095) / {int(high) - int(low)})",
            "zero": "0",
            "kind": kind,
        }
    held = {c.name: float(c.value) for c in plan.coefficients}
    low, high = held.get("u_min", -1.0), held.get("u_max", 1.0)
    kind = result_type(plan.number)
    part, start, scale, zero = (
        float_literal(x, plan.number) for x in (1 / 2048, low, _scale(plan, low, high), 0.0)
    )
    return {
        "y": f"({kind})(raw - 2048) * {part}",
        "duty": f"(uint32_t)((u - ({start})) * {scale})",
        "zero": zero,
        "kind": kind,
    }


def _scale(plan: Plan, low: float, high: float) -> float:
    scale = 4095.0 / (high - low) if high > low else 1.0
    return float(np.float32(scale)) if plan.number == "f32" else scale


def _arduino(plan: Plan) -> str:
    n, words = plan.name, _literals(plan)
    kind = words["kind"]
    return f"""\
/* {n} on an Arduino board: paced by micros(); a timer interrupt does it with less jitter. */
#include <Arduino.h>
#include "{n}.h"

static {n}_state state;
static uint32_t due;
static const uint32_t period_us = {_period_us(plan)}UL; /* {plan.dt:.9g} s */

static {kind} measured()
{{
    const int32_t raw = analogRead(A0) * 4L; /* {_ADAPT}10 bits to 12 */
    return {words["y"]}; /* {_ADAPT}to the units of y, see {n}.h */
}}

static void actuate({kind} u)
{{
    const uint32_t duty = {words["duty"]}; /* 0 ... 4095 over u's limits */
    analogWrite(9, (int)(duty / 16)); /* {_ADAPT}what drives the plant */
}}

void setup()
{{
    pinMode(9, OUTPUT);
    {n}_init(&state);
    while ({n}_selftest() != 0) {{
        /* this board computes something else: it does not start */
    }}
    due = micros();
}}

void loop()
{{
    if ((int32_t)(micros() - due) >= 0) {{
        const {kind} reference = {words["zero"]}; /* {_ADAPT}where y should go */
        due += period_us;
        actuate({n}_step(&state, reference, measured(), {words["zero"]}));
    }}
}}
"""


def _stm32(plan: Plan) -> str:
    n, words = plan.name, _literals(plan)
    kind = words["kind"]
    return f"""\
/* {n} in a timer interrupt with STM32's HAL. {_ADAPT}handles and channels, here TIM6 with an
   update event every {plan.dt:.9g} s, ADC1 on the measurement, DAC1 on the plant. */
#include "main.h"
#include "{n}.h"

extern TIM_HandleTypeDef htim6;
extern ADC_HandleTypeDef hadc1;
extern DAC_HandleTypeDef hdac1;

void {n}_start(void);

static {n}_state state;
static volatile {kind} reference = {words["zero"]}; /* {_ADAPT}where y should go */

void {n}_start(void)
{{
    {n}_init(&state);
    if ({n}_selftest() != 0) {{
        Error_Handler(); /* this compiler or processor computes something else */
    }}
    (void)HAL_DAC_Start(&hdac1, DAC_CHANNEL_1);
    (void)HAL_TIM_Base_Start_IT(&htim6);
}}

static {kind} measured(void)
{{
    int32_t raw = 2048;
    (void)HAL_ADC_Start(&hadc1);
    if (HAL_ADC_PollForConversion(&hadc1, 1U) == HAL_OK) {{
        raw = (int32_t)HAL_ADC_GetValue(&hadc1);
    }}
    return {words["y"]}; /* {_ADAPT}to the units of y, see {n}.h */
}}

static void actuate({kind} u)
{{
    const uint32_t duty = {words["duty"]}; /* 0 ... 4095 over u's limits */
    (void)HAL_DAC_SetValue(&hdac1, DAC_CHANNEL_1, DAC_ALIGN_12B_R, duty);
}}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim)
{{
    if (htim == &htim6) {{
        actuate({n}_step(&state, reference, measured(), {words["zero"]}));
    }}
}}
"""

"""The examples compile as they are, with the boards' headers stubbed."""

import pytest
from designs import made
from host import STRICT, compiled, compilers

from zoh.firmware.c import emit
from zoh.firmware.lines import NUMBERS
from zoh.firmware.wiring import wiring

ARDUINO = """\
#include <stdint.h>
#define A0 14
#define OUTPUT 1
extern "C" { int analogRead(int); void analogWrite(int, int); void pinMode(int, int); }
extern "C" uint32_t micros(void);
void setup(); void loop();
"""
STM32 = """\
#include <stdint.h>
typedef struct { int x; } TIM_HandleTypeDef;
typedef struct { int x; } ADC_HandleTypeDef;
typedef struct { int x; } DAC_HandleTypeDef;
typedef enum { HAL_OK, HAL_ERROR } HAL_StatusTypeDef;
#define DAC_CHANNEL_1 0U
#define DAC_ALIGN_12B_R 0U
HAL_StatusTypeDef HAL_DAC_Start(DAC_HandleTypeDef *h, uint32_t channel);
HAL_StatusTypeDef HAL_TIM_Base_Start_IT(TIM_HandleTypeDef *h);
HAL_StatusTypeDef HAL_ADC_Start(ADC_HandleTypeDef *h);
HAL_StatusTypeDef HAL_ADC_PollForConversion(ADC_HandleTypeDef *h, uint32_t timeout);
uint32_t HAL_ADC_GetValue(ADC_HandleTypeDef *h);
HAL_StatusTypeDef HAL_DAC_SetValue(DAC_HandleTypeDef *h, uint32_t c, uint32_t a, uint32_t v);
void Error_Handler(void);
void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim);
"""


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("limits", [{}, {"u_min": None, "u_max": None, "u_range": (-12, 12)}])
def test_the_examples_compile(number, limits, tmp_path):
    plan = made("pid", number, **limits)
    for name, text in (emit(plan) | wiring(plan)).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "Arduino.h").write_text(ARDUINO)
    (tmp_path / "main.h").write_text(STM32)
    command, out = compilers()[0], ["-c", f"-I{tmp_path}", "-o", str(tmp_path / "made.o")]
    compiled(command, tmp_path / "ctl.ino", "-x", "c++", "-std=c++17", *STRICT, *out)
    compiled(command, tmp_path / "ctl_stm32.c", "-std=c99", *STRICT, *out)


def test_the_readme_names_clock_units_and_functions():
    text = wiring(made("pid", "q15"))["README.md"]
    for said in ("0.1 s", "ctl_step", "ctl_track", "ctl_selftest", "0.000366", "-ffast-math"):
        assert said in text
    assert wiring(made("pid", "q15"))["README.md"] == text

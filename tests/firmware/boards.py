"""What the examples need of a board's software, declared and no more: enough to compile them."""

ARDUINO = """\
#include <stdint.h>
#define A0 14
#define A1 15
int analogRead(uint8_t pin);
void analogWrite(uint8_t pin, int value);
unsigned long micros(void);
void setup(void);
void loop(void);
"""
HAL = """\
#include <stdint.h>
typedef struct { volatile uint32_t CR1, CNT; } TIM_TypeDef;
#define __HAL_TIM_GET_COUNTER(htim) ((htim)->Instance->CNT)
typedef struct { TIM_TypeDef *Instance; } TIM_HandleTypeDef;
typedef struct { uint32_t State; } ADC_HandleTypeDef;
typedef struct { uint32_t State; } DAC_HandleTypeDef;
typedef enum { HAL_OK, HAL_ERROR } HAL_StatusTypeDef;
#define TIM6 ((TIM_TypeDef *)0x40001000U)
#define DAC_CHANNEL_1 0U
#define DAC_ALIGN_12B_R 0U
HAL_StatusTypeDef HAL_ADC_Start(ADC_HandleTypeDef *hadc);
HAL_StatusTypeDef HAL_ADC_PollForConversion(ADC_HandleTypeDef *hadc, uint32_t timeout);
uint32_t HAL_ADC_GetValue(ADC_HandleTypeDef *hadc);
HAL_StatusTypeDef HAL_DAC_Start(DAC_HandleTypeDef *hdac, uint32_t channel);
HAL_StatusTypeDef HAL_DAC_SetValue(
    DAC_HandleTypeDef *hdac, uint32_t channel, uint32_t alignment, uint32_t data);
HAL_StatusTypeDef HAL_TIM_Base_Start_IT(TIM_HandleTypeDef *htim);
void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim);
void Error_Handler(void);
"""

#include "stage.h"

#include "board.h"
#include "device.h"
#include "registers.h"
#include "wait.h"

static uint32_t off_code = CONVERT_ZERO; ///< code for zero current

void stage_init(const drive_config_t *config, loop_force_t no_current)
{
    (void)config;
    off_code = convert_output(no_current);
    clock_on(&RCC->AHB1ENR, RCC_AHB1ENR_GPIOAEN);
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_DACEN);
    DAC->DHR12R1 = off_code; // zero before the DAC is on, so that the pin shows no other level
    GPIOA->MODER |= 3u << (2 * 0) | 3u << (2 * 1) | 3u << (2 * 2) | 3u << (2 * 3) | 3u << (2 * 4); // analog
    DAC->CR |= DAC_CR_BOFF1; // buffer off, because it does not reach the rails
    DAC->CR |= DAC_CR_EN1;
}

// --- the power stage's measurements --------------------------------------------------------------------------------

static uint32_t measured_codes[CONVERT_MEASURED]; ///< codes of ADC2's channels 1 to 3
static uint32_t measured_channel;

static void convert_next(void)
{
    measured_channel = measured_channel % CONVERT_MEASURED + 1u;
    ADC2->SQR3       = measured_channel;
    ADC2->CR2 |= ADC_CR2_SWSTART;
}

static bool take_measured(void)
{
    const bool is_done = (ADC2->SR & ADC_SR_EOC) != 0u;
    if (is_done)
    {
        measured_codes[measured_channel - 1u] = ADC2->DR & 0xfffu; // reading clears EOC
    }
    return is_done;
}

/// Measures each quantity once, so that the first tick has all of them.
static void start_measuring(void)
{
    for (uint32_t i = 0; i < CONVERT_MEASURED; i++)
    {
        convert_next();
        (void)wait_for(&ADC2->SR, ADC_SR_EOC, ADC_SR_EOC);
        (void)take_measured();
    }
    convert_next();
}

/// Takes the measurements. A conversion takes 23 us of a tick; if it has not ended within the tick, every level is exceeded.
void stage_measure(port_measured_t *measured)
{
    const bool is_done = take_measured();
    convert_next();
    *measured = is_done ? convert_measured(measured_codes) : (port_measured_t){INT32_MAX, INT32_MAX, INT32_MAX, 0};
}

// --- the sensor ----------------------------------------------------------------------------------------------------

#define CONVERSIONS_MIN 4u // least number in a tick; there are 42 at 168 MHz, 8 at 16 MHz

static uint32_t adc_sum, adc_count; // since the last tick; only interrupts of one priority write them

void ADC_IRQHandler(void);

void ADC_IRQHandler(void)
{
    if ((ADC1->SR & ADC_SR_EOC) != 0u && adc_count < CONVERT_READINGS_MAX)
    {
        adc_sum += ADC1->DR & 0xfffu; // reading clears EOC
        adc_count++;
    }
    else
    {
        ADC1->SR = 0;
    }
}

bool stage_read_sensor(loop_force_t *reading)
{
    const uint32_t count = adc_count;
    const uint32_t sum   = adc_sum;
    adc_count            = 0;
    adc_sum              = 0;
    if (count < CONVERSIONS_MIN)
    {
        return false;
    }
    *reading = convert_sensor(sum, count);
    return true;
}

void stage_start(uint32_t apb_hz)
{
    (void)apb_hz;
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_ADC1EN);
    ADC_CCR     = ADC_CCR_ADCPRE_DIV4; // 21 MHz from 84 MHz
    ADC1->SMPR2 = ADC_SMPR2_SMP0_480;  // with 12 more cycles, a conversion takes 23.4 us
    ADC1->SQR1  = 0;                   // one conversion ...
    ADC1->SQR3  = 0;                   // ... of channel 0
    ADC1->CR1   = ADC_CR1_EOCIE;
    ADC1->CR2   = ADC_CR2_ADON | ADC_CR2_CONT;
    // The measurements of the power stage, one of them a tick.
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_ADC2EN);
    ADC2->SMPR2 = ADC_SMPR2_SMP1_480 | ADC_SMPR2_SMP2_480 | ADC_SMPR2_SMP3_480;
    ADC2->SQR1  = 0;
    ADC2->CR2   = ADC_CR2_ADON;
    board_start_interrupt(ADC_IRQn, BOARD_TICK_PRIORITY); // priority of the tick, so that neither interrupts the other
    ADC1->CR2 |= ADC_CR2_SWSTART;
    start_measuring();
}

// --- outputs -------------------------------------------------------------------------------------------------------

void stage_off(void)
{
    DAC->DHR12R1 = off_code;
}

bool stage_is_off(void)
{
    return true; // only the enable output switches
}

void stage_enable(bool on)
{
    (void)on;
}

void stage_command(loop_force_t output)
{
    DAC->DHR12R1 = convert_output(output);
}

uint32_t stage_inputs(void)
{
    return 0;
}

bool stage_suits(const drive_config_t *config, drive_config_error_t *error)
{
    (void)config;
    (void)error;
    return true;
}

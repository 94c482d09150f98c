// The bridge: TIM1 switches the legs, its channel 4 starts the converters in the middle of each period, and their interrupt
// runs the current loop.
//
//                 TOP        .            .
//     TIM1       /  \      /  \      20 kHz, centre-aligned
//               /    \    /    \ .
//     leg 0    ____    ________    high below CCR1
//                  ____        ___
//     ADC          ^ codes: at the top both low sides are on, and the current is its mean of the period
//     handler      ...     new compare values ...
//     preload          ^   ... act from the next period on

#include "stage.h"

#include "board.h"
#include "bridge/bridge.h"
#include "device.h"
#include "registers.h"
#include "wait.h"
#include "wiring.h"

#include <stddef.h>

// --- params --------------------------------------------------------------------------------------------------------

#define SAMPLE_LEAD_NS 350u // half of 15 cycles of 21 MHz, so that the codes are held at the top
#define TRIP_MOST_A    7.5f // less than the sensor's 8.25 A, so that a trip comes before the rail
#define BUS_TRIP       1.2f // from this multiple of bus_high_v on, the bridge turns off at once and not after bus_voltage_ms
#define READY_LEAST_MS 20u // calibration takes 12.8 ms

_Static_assert(WIRING_LEGS == 2 || WIRING_LEGS == 3, "a motor with one winding, or three phases");

static bridge_t         bridge;
static bridge_brushed_t motor;
static uint32_t         dead_time_ns;
static bool             break_is_high;
static float            top;

static current_config_t current_config_of(const drive_config_t *config)
{
    return (current_config_t){.resistance_ohm = config->motor_resistance_ohm,
                              .inductance_h   = config->motor_inductance_h,
                              .bandwidth_hz   = config->current_bandwidth_hz,
                              .sample_time_s  = 1.0f / (float)BRIDGE_HZ,
                              .limit_a        = config->current_max_a};
}

static bool refuse(drive_config_error_t *error, unsigned field, float value, float low, float high)
{
    *error = (drive_config_error_t){.field = field, .value = value, .low = low, .high = high};
    return false;
}

bool stage_suits(const drive_config_t *config, drive_config_error_t *error)
{
    const current_config_t current = current_config_of(config);
    const float            most_hz = current_bandwidth_max_hz(current.sample_time_s);
    const float            most_a  = config->current_max_a;
    const float            least_h = current.resistance_ohm * current.sample_time_s / CURRENT_POLE_MAX;
    current_params_t       unused;
    if (!(most_a > 0.0f && most_a <= TRIP_MOST_A / 1.2f))
    {
        return refuse(error, DRIVE_CONFIG_current_max_a, most_a, 1e-6f, TRIP_MOST_A / 1.2f);
    }
    if (!(config->bridge_trip_a >= 1.2f * most_a && config->bridge_trip_a <= TRIP_MOST_A))
    {
        return refuse(error, DRIVE_CONFIG_bridge_trip_a, config->bridge_trip_a, 1.2f * most_a, TRIP_MOST_A);
    }
    if (config->current_bandwidth_hz > most_hz)
    {
        return refuse(error, DRIVE_CONFIG_current_bandwidth_hz, config->current_bandwidth_hz, 10.0f, most_hz);
    }
    if (config->ready_ms < READY_LEAST_MS)
    {
        return refuse(error, DRIVE_CONFIG_ready_ms, (float)config->ready_ms, (float)READY_LEAST_MS, 10000.0f);
    }
    return current_init(&unused, &current) ||
           refuse(error, DRIVE_CONFIG_motor_inductance_h, config->motor_inductance_h, least_h, 10.0f);
}

// --- pins and peripherals ------------------------------------------------------------------------------------------

/// Sets up the pins; nothing switches until stage_start.
void stage_init(const drive_config_t *config, loop_force_t no_current)
{
    (void)no_current;
    const current_config_t current = current_config_of(config);
    // A law of your own, e.g. FOC, replaces these three.
    const bridge_params_t params = {.a_per_code = (float)CONVERT_CURRENT_MA * 1e-3f / (float)CONVERT_CODES,
                                    .v_per_code = (float)CONVERT_BUS_MV * 1e-3f / (float)CONVERT_CODES,
                                    .trip_a     = config->bridge_trip_a,
                                    .trip_v     = BUS_TRIP * config->bus_high_v,
                                    .currents   = WIRING_LEGS - 1,
                                    .law        = bridge_brushed,
                                    .context    = &motor,
                                    .begin      = bridge_brushed_begin};
    (void)current_init(&motor.params, &current); // with a config that is refused the drive never starts
    motor.dead_share = bridge_dead_share(config->dead_time_ns);
    bridge_init(&bridge, &params);
    dead_time_ns  = config->dead_time_ns;
    break_is_high = config->fault_level != 0u;
    clock_on(&RCC->AHB1ENR, RCC_AHB1ENR_GPIOAEN);
    GPIOA->MODER |= 3u << (2 * 0) | 3u << (2 * 1) | 3u << (2 * 2) | 3u << (2 * 3) | 3u << (2 * 4); // analog
}

/// Connects the gates of the legs and the break input to TIM1, alternate function 1.
static void connect_legs(void)
{
    for (uint32_t leg = 0; leg < WIRING_LEGS; leg++)
    {
        GPIOA->AFRH |= 1u << (4 * leg);       // PA8 and on
        GPIOB->AFRH |= 1u << (4 * (5 + leg)); // PB13 and on
        GPIOA->MODER |= 2u << (2 * (8 + leg));
        GPIOB->MODER |= 2u << (2 * (13 + leg));
    }
}

static void start_timer1(uint32_t timer_hz)
{
    const uint32_t cycles = timer_hz / (2u * BRIDGE_HZ);
    const uint32_t lead   = timer_hz / 1000000u * SAMPLE_LEAD_NS / 1000u;
    top                   = (float)cycles;
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_TIM1EN);
    GPIOB->AFRH |= 1u << (4 * (WIRING_FAULT_PIN - 8));
    GPIOB->MODER |= 2u << (2 * WIRING_FAULT_PIN); // the pin's interrupt stays
    TIM1->PSC   = 0;
    TIM1->ARR   = cycles;
    TIM1->CCMR1 = TIM_CCMR_OC1_PWM1 | TIM_CCMR_OC2_PWM1;
    TIM1->CCMR2 = TIM_CCMR_OC1_PWM1 | TIM_CCMR_OC4_PWM2; // channels 3 and 4
    TIM1->CCR1 = TIM1->CCR2 = TIM1->CCR3 = cycles / 2u;
    TIM1->CCR4                           = cycles - lead;
    TIM1->CCER                           = TIM_CCER_LEG1 | TIM_CCER_LEG2 | (WIRING_LEGS == 3 ? TIM_CCER_LEG3 : 0u);
    TIM1->CR2                            = TIM_CR2_MMS_OC4REF;
    TIM1->EGR                            = TIM_EGR_UG; // loads the preloaded registers
    TIM1->SR                             = 0;
    // The outputs are off, all gates low (the OIS bits are 0) and the break armed. The dead time and these settings are
    // locked until the next reset.
    TIM1->BDTR = TIM_BDTR_LOCK3 | TIM_BDTR_OSSI | TIM_BDTR_OSSR | TIM_BDTR_BKE | (break_is_high ? TIM_BDTR_BKP : 0u) |
                 convert_dead_time(dead_time_ns, timer_hz);
    TIM1->CR1 = TIM_CR1_ARPE | TIM_CR1_CMS_DOWN | TIM_CR1_CEN;
    connect_legs(); // comes last, when the timer holds the gates low
}

#define JSQR_1      (0u << 20) // number of conversions minus one
#define JSQR_4      (3u << 20)
#define JSQR_ORDER  (1u | 4u << 5 | 2u << 10 | 3u << 15) // current, second current, bus, temperature
#define SLOW_APB_HZ 16000000u

void stage_start(uint32_t apb_hz)
{
    const uint32_t triggered = ADC_CR2_ADON | ADC_CR2_JEXTSEL_T1 | ADC_CR2_JEXTEN_RISE;
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_ADC1EN);
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_ADC2EN);
    ADC_CCR     = ADC_CCR_ADCPRE_DIV4; // 21 MHz from 84 MHz
    ADC1->SMPR2 = ADC_SMPR2_SMP0_56;   // 3.2 us, within the 5.1 us of the others
    ADC1->JSQR  = JSQR_1;              // channel 0
    ADC1->CR2   = triggered;
    ADC2->SMPR2 = ADC_SMPR2_SMP1_15 | ADC_SMPR2_SMP2_15 | ADC_SMPR2_SMP3_15 | ADC_SMPR2_SMP4_15;
    ADC2->JSQR  = JSQR_4 | JSQR_ORDER;
    ADC2->CR1   = ADC_CR1_SCAN | ADC_CR1_JEOCIE;
    ADC2->CR2   = triggered;
    board_start_interrupt(ADC_IRQn, BOARD_STAGE_PRIORITY);
    start_timer1(apb_hz == SLOW_APB_HZ ? apb_hz : 2u * apb_hz); // the timer has twice APB2's clock if that is divided
}

// --- the current loop ----------------------------------------------------------------------------------------------

static uint32_t          measured_codes[CONVERT_MEASURED];
static volatile uint32_t sensor_sum, sensor_count; ///< readings since the last tick

void ADC_IRQHandler(void);

static bool are_on(void)
{
    return (TIM1->BDTR & TIM_BDTR_MOE) != 0u;
}

static void switch_off(void)
{
    TIM1->BDTR &= ~TIM_BDTR_MOE;
}

/// Turns the legs on. A stop may come at any time, and the legs that it turns off must stay off.
static void switch_on(void)
{
    const uint32_t mask = __get_PRIMASK();
    __disable_irq();
    if (bridge.is_wanted)
    {
        TIM1->BDTR |= TIM_BDTR_MOE; // ignored while the break input is active
    }
    __set_PRIMASK(mask);
}

static uint32_t compare_of(float duty)
{
    const float within = duty > 0.0f ? (duty < 1.0f ? duty : 1.0f) : 0.0f; // 0 for a NaN
    return (uint32_t)(within * top + 0.5f);
}

void ADC_IRQHandler(void)
{
    const bridge_sample_t sample = {.current = {ADC2->JDR1, ADC2->JDR2}, .bus = ADC2->JDR3};
    const bool            before = are_on();
    bridge_duty_t         duty;
    measured_codes[1] = sample.bus;
    measured_codes[2] = ADC2->JDR4;
    if ((ADC1->SR & ADC_SR_JEOC) != 0u && sensor_count < CONVERT_READINGS_MAX)
    {
        sensor_sum   = sensor_sum + ADC1->JDR1;
        sensor_count = sensor_count + 1u;
    }
    const bool on = bridge_step(&bridge, &sample, before, &duty);
    TIM1->CCR1    = compare_of(duty.leg[0]);
    TIM1->CCR2    = compare_of(duty.leg[1]);
    TIM1->CCR3    = compare_of(duty.leg[2]);
    if (before && !on)
    {
        switch_off();
    }
    if (on && !before)
    {
        switch_on();
    }
    ADC1->SR = 0;
    ADC2->SR = 0;
}

// --- functions of the tick -----------------------------------------------------------------------------------------

#define CONVERSIONS_MIN 4u // least number in a tick; there are 20

bool stage_read_sensor(loop_force_t *reading)
{
    const uint32_t mask = __get_PRIMASK();
    __disable_irq(); // so that sum and count belong together
    const uint32_t count = sensor_count;
    const uint32_t sum   = sensor_sum;
    sensor_count         = 0;
    sensor_sum           = 0;
    __set_PRIMASK(mask);
    if (count < CONVERSIONS_MIN)
    {
        return false;
    }
    *reading = convert_sensor(sum, count);
    return true;
}

/// Returns the current of the last period, relative to the offset that the bridge has found.
void stage_measure(port_measured_t *measured)
{
    *measured            = convert_measured(measured_codes);
    measured->current_ma = (int32_t)(bridge.measured.current_a[0] * 1000.0f);
}

void stage_off(void)
{
    bridge_want(&bridge, false);
    switch_off();
}

bool stage_is_off(void)
{
    return !bridge.is_wanted && !are_on();
}

void stage_enable(bool on)
{
    bridge_want(&bridge, on);
    if (!on)
    {
        switch_off();
    }
}

void stage_command(loop_force_t output)
{
    bridge_command(&bridge, convert_bridge(output));
}

uint32_t stage_inputs(void)
{
    const bridge_trip_t trip  = bridge_take_trip(&bridge);
    const uint32_t      ready = bridge.state == BRIDGE_ON ? 0u : PORT_INPUT_NOT_READY;
    return ready | (trip == BRIDGE_TRIP_CURRENT ? PORT_INPUT_OVER_CURRENT
                    : trip == BRIDGE_TRIP_BUS   ? PORT_INPUT_OVER_VOLTAGE
                    : trip != BRIDGE_TRIP_NONE  ? PORT_INPUT_POWER_FAULT
                                                : 0u);
}

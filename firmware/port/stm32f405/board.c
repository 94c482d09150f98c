#include "board.h"

#include "convert.h"
#include "device.h"
#include "registers.h"

// Every wait has a time-out, in turns of its loop of about 10 cycles each. Each caller says what happens when it runs out.
#define WAIT_TURNS 100000u

static bool wait_for_turns(const reg_t *reg, uint32_t mask, uint32_t value, uint32_t turns)
{
    for (uint32_t turn = 0; turn < turns; turn++)
    {
        if ((*reg & mask) == value)
        {
            return true;
        }
    }
    return false;
}

static bool wait_for(const reg_t *reg, uint32_t mask, uint32_t value)
{
    return wait_for_turns(reg, mask, value, WAIT_TURNS);
}

/// A peripheral may ignore a write in the first cycles of its clock (RM0090); the read-back alone is not long enough.
static void clock_on(reg_t *enable, uint32_t bits)
{
    *enable |= bits;
    (void)*enable;
    __DSB();
}

// --- clock ---------------------------------------------------------------------------------------------------------

/// 168 MHz: PLLM is `input_mhz`, the VCO runs at 336 MHz. False, with the chip still on HSI, if the PLL does not lock or the
/// switch to it fails.
static bool start_pll(uint32_t input_mhz, uint32_t source)
{
    // Bus dividers first: they act some cycles after the write, before the PLL has locked.
    RCC->CFGR = RCC_CFGR_PPRE1_DIV4 | RCC_CFGR_PPRE2_DIV2;
    RCC->CR &= ~RCC_CR_PLLON;
    if (!wait_for(&RCC->CR, RCC_CR_PLLRDY, 0))
    {
        return false;
    }
    RCC->PLLCFGR = input_mhz | 336u << RCC_PLLCFGR_PLLN_Pos | source | 7u << RCC_PLLCFGR_PLLQ_Pos;
    RCC->CR |= RCC_CR_PLLON;
    if (!wait_for(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY))
    {
        RCC->CR &= ~RCC_CR_PLLON;
        return false;
    }
    // Flash before the switch: it needs 5 wait states at 168 MHz.
    FLASH_ACR = FLASH_ACR_LATENCY_5WS | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN;
    if (!wait_for(&FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_LATENCY_5WS))
    {
        return false;
    }
    RCC->CFGR |= RCC_CFGR_SW_PLL;
    if (!wait_for(&RCC->CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_PLL))
    {
        RCC->CFGR &= ~RCC_CFGR_SW;
        return false;
    }
    return true;
}

/// After reset the chip runs from HSI, and stays there if neither crystal nor PLL starts.
static board_clock_t start_clock(void)
{
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_PWREN);
    PWR_CR |= PWR_CR_VOS;
    RCC->CR |= RCC_CR_HSEON;
    if (wait_for(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && start_pll(8, RCC_PLLCFGR_PLLSRC_HSE))
    {
        RCC->CR |= RCC_CR_CSSON; // a crystal that stops would slow all timers alike: raise an NMI
        return BOARD_CLOCK_HSE;
    }
    RCC->CR &= ~RCC_CR_HSEON;
    if (start_pll(16, 0))
    {
        return BOARD_CLOCK_HSI;
    }
    RCC->CFGR = 0; // the internal oscillator, undivided
    return BOARD_CLOCK_SLOW;
}

// --- pins and peripherals ------------------------------------------------------------------------------------------

#define ENABLE_PIN 0
#define STOP_PIN   1
#define FAULT_PIN  12

static void start_pins(void)
{
    clock_on(&RCC->AHB1ENR, RCC_AHB1ENR_GPIOAEN | RCC_AHB1ENR_GPIOBEN);
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_DACEN);
    // Set the level before the direction, and zero before the DAC is on, so that neither pin shows another level.
    GPIOB->BSRR = 1u << (ENABLE_PIN + 16);
    GPIOB->MODER |= 1u << (2 * ENABLE_PIN);
    GPIOB->PUPDR |= 1u << (2 * STOP_PIN) | 1u << (2 * FAULT_PIN); // pull-ups: an open wire reads high
    DAC->DHR12R1 = CONVERT_ZERO;
    GPIOA->MODER |= 3u << (2 * 0) | 3u << (2 * 4); // analog
    DAC->CR |= DAC_CR_BOFF1;                       // buffer off: it does not reach the rails
    DAC->CR |= DAC_CR_EN1;
}

/// Latches edges of the two stop inputs, so that a pulse between two ticks is seen. No interrupt is enabled for them.
static void start_edges(void)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_SYSCFGEN);
    SYSCFG->EXTICR[STOP_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (STOP_PIN % 4));
    SYSCFG->EXTICR[FAULT_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (FAULT_PIN % 4));
    EXTI->RTSR |= 1u << STOP_PIN | 1u << FAULT_PIN;
    EXTI->IMR |= 1u << STOP_PIN | 1u << FAULT_PIN;
}

/// Below about 2.9 V neither the flash at 168 MHz nor the converters are reliable.
static void watch_supply(void)
{
    EXTI->RTSR |= 1u << PVD_LINE;
    EXTI->IMR |= 1u << PVD_LINE;
    NVIC_SetPriority(PVD_IRQn, 0);
    NVIC_EnableIRQ(PVD_IRQn); // handled by Default_Handler
    PWR_CR |= PWR_CR_PLS_2V8; // 2.85 to 2.99 V
    PWR_CR |= PWR_CR_PVDE;    // last: if the supply is low already, this gives the only edge
}

static void start_usart(uint32_t clock_hz)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_USART1EN);
    GPIOA->PUPDR |= 1u << (2 * 10);                            // pull-up: an open wire reads idle
    GPIOA->AFRH |= 7u << (4 * (9 - 8)) | 7u << (4 * (10 - 8)); // AF7
    GPIOA->MODER |= 2u << (2 * 9) | 2u << (2 * 10);
    USART1->BRR = (clock_hz + 57600u) / 115200u;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
}

/// From 0 upwards at 1 MHz.
static void start_timer(tim_t *timer, uint32_t clock_hz, uint32_t reload, uint32_t interrupts)
{
    timer->PSC  = clock_hz / 1000000u - 1u;
    timer->ARR  = reload;
    timer->EGR  = TIM_EGR_UG; // loads the prescaler ...
    timer->SR   = 0;          // ... without a tick
    timer->DIER = interrupts;
    timer->CR1  = TIM_CR1_CEN;
}

static void start_adc(void)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_ADC1EN);
    ADC_CCR     = ADC_CCR_ADCPRE_DIV4; // 21 MHz of 84
    ADC1->SMPR2 = ADC_SMPR2_SMP0_480;  // with 12 more cycles a conversion every 23.4 us
    ADC1->SQR1  = 0;                   // one conversion ...
    ADC1->SQR3  = 0;                   // ... of channel 0
    ADC1->CR1   = ADC_CR1_EOCIE;
    ADC1->CR2   = ADC_CR2_ADON | ADC_CR2_CONT;
}

static uint32_t timer_hz;

board_clock_t board_init(void)
{
    start_pins();
    start_edges();
    const board_clock_t clock = start_clock();
    const bool          slow  = clock == BOARD_CLOCK_SLOW;
    timer_hz                  = slow ? 16000000u : 84000000u; // twice APB1's clock where that is divided
    start_usart(slow ? 16000000u : 84000000u);
    start_adc();
    return clock;
}

bool board_was_reset_by_watchdog(void)
{
    const uint32_t causes = RCC->CSR;
    RCC->CSR |= RCC_CSR_RMVF;
    return (causes & RCC_CSR_IWDGRSTF) != 0u;
}

#define PRIORITY 8u // of 0 to 15

void board_start(void)
{
    // One priority for both, so that neither interrupts the other.
    NVIC_SetPriority(TIM2_IRQn, PRIORITY);
    NVIC_SetPriority(ADC_IRQn, PRIORITY);
    NVIC_EnableIRQ(TIM2_IRQn);
    NVIC_EnableIRQ(ADC_IRQn);

    IWDG->KR  = IWDG_KR_START;
    IWDG->KR  = IWDG_KR_ACCESS;
    IWDG->PR  = 0;   // LSI / 4, 8 kHz (4 to 12)
    IWDG->RLR = 240; // 30 ms (20 to 60)
    // If this times out the watchdog runs with its longest period until the new one is loaded.
    (void)wait_for(&IWDG->SR, IWDG_SR_PVU | IWDG_SR_RVU, 0);
    board_kick();
    watch_supply();

    clock_on(&RCC->APB1ENR, RCC_APB1ENR_TIM2EN | RCC_APB1ENR_TIM5EN);
    EXTI->PR = 1u << STOP_PIN | 1u << FAULT_PIN; // edges that the pull-ups made
    ADC1->CR2 |= ADC_CR2_SWSTART;
    start_timer(TIM5, timer_hz, UINT32_MAX, 0);
    start_timer(TIM2, timer_hz, BOARD_TICK_US - 1u, TIM_DIER_UIE);
}

void board_kick(void)
{
    IWDG->KR = IWDG_KR_RELOAD;
}

void board_off(void)
{
    GPIOB->BSRR  = 1u << (ENABLE_PIN + 16);
    DAC->DHR12R1 = CONVERT_ZERO;
}

int board_read_byte(void)
{
    const uint32_t status = USART1->SR;
    if ((status & (USART_SR_RXNE | USART_SR_ORE)) == 0u)
    {
        return BOARD_NO_BYTE;
    }
    const int byte = (int)(USART1->DR & 0xffu); // clears the errors as well
    if ((status & USART_SR_ORE) != 0u)
    {
        return BOARD_OVERRUN;
    }
    return (status & (USART_SR_PE | USART_SR_FE | USART_SR_NF)) == 0u ? byte : BOARD_BAD_BYTE;
}

// --- interrupts ----------------------------------------------------------------------------------------------------

#define CONVERSIONS_MIN 4u // in a tick; 42 at 168 MHz, 8 at 16 MHz

static uint32_t adc_sum, adc_count; // since the last tick; only interrupts of one priority write them

void ADC_IRQHandler(void);
void TIM2_IRQHandler(void);

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

void TIM2_IRQHandler(void)
{
    TIM2->SR = ~TIM_SR_UIF;
    board_tick();
}

// --- the drive's port ----------------------------------------------------------------------------------------------

static bool read_sensor(void *context, loop_force_t *reading)
{
    (void)context;
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

static void command(void *context, loop_force_t output)
{
    (void)context;
    DAC->DHR12R1 = convert_output(output);
}

static void enable(void *context, bool on)
{
    (void)context;
    GPIOB->BSRR = on ? 1u << ENABLE_PIN : 1u << (ENABLE_PIN + 16);
}

static uint32_t inputs(void *context)
{
    (void)context;
    const uint32_t edges = EXTI->PR & (1u << STOP_PIN | 1u << FAULT_PIN);
    EXTI->PR             = edges; // writing ones clears; an edge from here on counts in the next tick
    const uint32_t seen  = edges | GPIOB->IDR;
    return ((seen & (1u << STOP_PIN)) != 0u ? PORT_INPUT_EMERGENCY_STOP : 0u) |
           ((seen & (1u << FAULT_PIN)) != 0u ? PORT_INPUT_POWER_FAULT : 0u);
}

static uint32_t time_us(void *context)
{
    (void)context;
    return TIM5->CNT;
}

#define LOG_TURNS 4000u // 0.2 ms at 168 MHz, twice what a byte takes

/// If the USART is not ready in time the byte is dropped, and later ones do not wait: the watchdog would reset the chip.
static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    static bool takes = true;
    takes             = wait_for_turns(&USART1->SR, USART_SR_TXE, USART_SR_TXE, takes ? LOG_TURNS : 1u);
    if (takes)
    {
        USART1->DR = byte;
    }
}

const port_t board_port = {.context     = 0,
                           .sensor      = CONVERT_SENSOR_RANGE,
                           .output      = CONVERT_OUTPUT_RANGE,
                           .read_sensor = read_sensor,
                           .command     = command,
                           .enable      = enable,
                           .inputs      = inputs,
                           .time_us     = time_us,
                           .log_byte    = log_byte};

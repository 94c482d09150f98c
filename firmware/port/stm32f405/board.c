#include "board.h"

#include "device.h"
#include "registers.h"

// Every wait is bounded, in turns of its loop: at 16 MHz some 10 cycles each. What follows when the flag does not come is
// said where it is waited for.
#define WAIT_TURNS 100000u

static bool wait_for(const reg_t *reg, uint32_t mask, uint32_t value)
{
    for (uint32_t turn = 0; turn < WAIT_TURNS; turn++)
    {
        if ((*reg & mask) == value)
        {
            return true;
        }
    }
    return false;
}

// --- clock ---------------------------------------------------------------------------------------------------------

/// 168 MHz of `input_mhz` as PLLM, 336 MHz in the VCO. False, and nothing changed, if it does not lock or take over.
static bool start_pll(uint32_t input_mhz, uint32_t source)
{
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
    // Flash first: at 168 MHz it needs 5 wait states.
    FLASH_ACR = FLASH_ACR_LATENCY_5WS | FLASH_ACR_PRFTEN | FLASH_ACR_ICEN | FLASH_ACR_DCEN;
    if (!wait_for(&FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_LATENCY_5WS))
    {
        return false;
    }
    RCC->CFGR = RCC_CFGR_PPRE1_DIV4 | RCC_CFGR_PPRE2_DIV2 | RCC_CFGR_SW_PLL;
    if (!wait_for(&RCC->CFGR, RCC_CFGR_SWS, RCC_CFGR_SWS_PLL))
    {
        RCC->CFGR = 0; // the internal oscillator, undivided
        return false;
    }
    return true;
}

/// Out of reset the chip runs from HSI, and stays there when nothing better starts.
static board_clock_t start_clock(void)
{
    RCC->APB1ENR |= RCC_APB1ENR_PWREN;
    PWR_CR |= PWR_CR_VOS;
    RCC->CR |= RCC_CR_HSEON;
    if (wait_for(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && start_pll(8, RCC_PLLCFGR_PLLSRC_HSE))
    {
        return BOARD_CLOCK_HSE;
    }
    RCC->CR &= ~RCC_CR_HSEON;
    return start_pll(16, 0) ? BOARD_CLOCK_HSI : BOARD_CLOCK_SLOW;
}

// --- pins and peripherals ------------------------------------------------------------------------------------------

#define ENABLE_PIN 0
#define STOP_PIN   1
#define FAULT_PIN  12

#define ZERO_CURRENT 2048 // of 4096 DAC steps

static void start_pins(void)
{
    RCC->AHB1ENR |= RCC_AHB1ENR_GPIOAEN | RCC_AHB1ENR_GPIOBEN;
    RCC->APB1ENR |= RCC_APB1ENR_DACEN;
    // The level before the direction, so that the output never shows anything else; zero before the DAC drives its pin.
    GPIOB->BSRR = 1u << (ENABLE_PIN + 16);
    GPIOB->MODER |= 1u << (2 * ENABLE_PIN);
    GPIOB->PUPDR |= 1u << (2 * STOP_PIN) | 1u << (2 * FAULT_PIN); // pull-ups: an open wire reads high
    DAC->DHR12R1 = ZERO_CURRENT;
    GPIOA->MODER |= 3u << (2 * 0) | 3u << (2 * 4); // analog
    DAC->CR |= DAC_CR_EN1;
}

static void start_usart(uint32_t clock_hz)
{
    RCC->APB2ENR |= RCC_APB2ENR_USART1EN;
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
    timer->EGR  = TIM_EGR_UG; // takes the prescaler over ...
    timer->SR   = 0;          // ... and is no tick
    timer->DIER = interrupts;
    timer->CR1  = TIM_CR1_CEN;
}

static void start_adc(void)
{
    RCC->APB2ENR |= RCC_APB2ENR_ADC1EN;
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
    const board_clock_t clock = start_clock();
    const bool          slow  = clock == BOARD_CLOCK_SLOW;
    timer_hz                  = slow ? 16000000u : 84000000u; // twice APB1's clock where that is divided
    start_usart(slow ? 16000000u : 84000000u);
    start_adc();
    return clock;
}

#define PRIORITY 8u // of 0 to 15

void board_start(void)
{
    // One priority for both, so that neither sees the other's data half-way.
    NVIC_SetPriority(TIM2_IRQn, PRIORITY);
    NVIC_SetPriority(ADC_IRQn, PRIORITY);
    NVIC_EnableIRQ(TIM2_IRQn);
    NVIC_EnableIRQ(ADC_IRQn);

    IWDG->KR  = IWDG_KR_START;
    IWDG->KR  = IWDG_KR_ACCESS;
    IWDG->PR  = 0;   // LSI / 4, 8 kHz (4 to 12)
    IWDG->RLR = 240; // 30 ms (20 to 60)
    // Without these the watchdog goes by its longest time until they come: later, but it does watch.
    (void)wait_for(&IWDG->SR, IWDG_SR_PVU | IWDG_SR_RVU, 0);
    board_kick();

    RCC->APB1ENR |= RCC_APB1ENR_TIM2EN | RCC_APB1ENR_TIM5EN;
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
    DAC->DHR12R1 = ZERO_CURRENT;
}

int board_read_byte(void)
{
    return (USART1->SR & USART_SR_RXNE) != 0u ? (int)(USART1->DR & 0xffu) : -1;
}

// --- interrupts ----------------------------------------------------------------------------------------------------

#define CONVERSIONS_MIN 4u // in a tick; 42 at 168 MHz, 8 at 16 MHz

static uint32_t adc_sum, adc_count; // of this tick, written in interrupts of one priority only

void ADC_IRQHandler(void);
void TIM2_IRQHandler(void);

void ADC_IRQHandler(void)
{
    if ((ADC1->SR & ADC_SR_EOC) != 0u && adc_count < 1024u)
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

/// The mean, with 12 bits after the point, as a part of full scale: code 0 is -2 N, 2048 is 0 N.
static bool read_force(void *context, loop_force_t *y)
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
    const int32_t mean = (int32_t)(((sum << 10) / count) << 2) - (2048 << 12); // a sum of 1024 codes fits
    *y                 = loop_force(mean * (1 << 7), BOARD_FULL_SCALE_N);
    return true;
}

static void command(void *context, loop_force_t u)
{
    (void)context;
    const int32_t code = ZERO_CURRENT + loop_part(u, BOARD_FULL_SCALE_N) / (1 << 19);
    DAC->DHR12R1       = (uint32_t)(code < 0 ? 0 : code > 4095 ? 4095 : code);
}

static void enable(void *context, bool on)
{
    (void)context;
    GPIOB->BSRR = on ? 1u << ENABLE_PIN : 1u << (ENABLE_PIN + 16);
}

static uint32_t inputs(void *context)
{
    (void)context;
    const uint32_t levels = GPIOB->IDR;
    return ((levels & (1u << STOP_PIN)) != 0u ? PORT_INPUT_EMERGENCY_STOP : 0u) |
           ((levels & (1u << FAULT_PIN)) != 0u ? PORT_INPUT_POWER_FAULT : 0u);
}

static uint32_t time_us(void *context)
{
    (void)context;
    return TIM5->CNT;
}

/// A byte that the USART does not take in time is lost: the log never holds anything up for long.
static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    if (wait_for(&USART1->SR, USART_SR_TXE, USART_SR_TXE))
    {
        USART1->DR = byte;
    }
}

const port_t board_port = {.context    = 0,
                           .read_force = read_force,
                           .command    = command,
                           .enable     = enable,
                           .inputs     = inputs,
                           .time_us    = time_us,
                           .log_byte   = log_byte};

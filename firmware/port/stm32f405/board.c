#include "board.h"

#include "convert.h"
#include "device.h"
#include "registers.h"

// Every wait is bounded, in turns of its loop: at 16 MHz some 10 cycles each. What follows when the flag does not come is
// said where it is waited for.
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

/// A peripheral may lose what is written to it in the first cycles of its clock. Reading back alone is not long enough.
static void clock_on(reg_t *enable, uint32_t bits)
{
    *enable |= bits;
    (void)*enable;
    __DSB();
}

// --- clock ---------------------------------------------------------------------------------------------------------

/// 168 MHz of `input_mhz` as PLLM, 336 MHz in the VCO. False, and still on HSI, if it does not lock or take over.
static bool start_pll(uint32_t input_mhz, uint32_t source)
{
    // The buses first: their dividers act some cycles after they are written, and the PLL takes longer to lock.
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
    // Flash first: at 168 MHz it needs 5 wait states.
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

/// Out of reset the chip runs from HSI, and stays there when nothing better starts.
static board_clock_t start_clock(void)
{
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_PWREN);
    PWR_CR |= PWR_CR_VOS;
    RCC->CR |= RCC_CR_HSEON;
    if (wait_for(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY) && start_pll(8, RCC_PLLCFGR_PLLSRC_HSE))
    {
        RCC->CR |= RCC_CR_CSSON; // without the crystal all timers would go wrong alike: an NMI instead
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
    // The level before the direction, so that the output never shows anything else; zero before the DAC drives its pin.
    GPIOB->BSRR = 1u << (ENABLE_PIN + 16);
    GPIOB->MODER |= 1u << (2 * ENABLE_PIN);
    GPIOB->PUPDR |= 1u << (2 * STOP_PIN) | 1u << (2 * FAULT_PIN); // pull-ups: an open wire reads high
    DAC->DHR12R1 = CONVERT_ZERO;
    GPIOA->MODER |= 3u << (2 * 0) | 3u << (2 * 4); // analog
    DAC->CR |= DAC_CR_BOFF1;                       // its buffer does not reach the ends of the range
    DAC->CR |= DAC_CR_EN1;
}

/// Edges of the inputs that stop the drive, for pulses that no tick sees. Pending only: no interrupt is enabled.
static void start_edges(void)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_SYSCFGEN);
    SYSCFG->EXTICR[STOP_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (STOP_PIN % 4));
    SYSCFG->EXTICR[FAULT_PIN / 4] |= SYSCFG_EXTICR_PB << (4 * (FAULT_PIN % 4));
    EXTI->RTSR |= 1u << STOP_PIN | 1u << FAULT_PIN;
    EXTI->IMR |= 1u << STOP_PIN | 1u << FAULT_PIN;
}

/// From some 2.9 V down neither the flash at 168 MHz nor the converters can be relied on.
static void watch_supply(void)
{
    EXTI->RTSR |= 1u << PVD_LINE;
    EXTI->IMR |= 1u << PVD_LINE;
    NVIC_SetPriority(PVD_IRQn, 0);
    NVIC_EnableIRQ(PVD_IRQn); // leads to Default_Handler
    PWR_CR |= PWR_CR_PLS_2V8; // 2.85 to 2.99 V
    PWR_CR |= PWR_CR_PVDE;    // last: of a supply that is low already this is the only edge
}

static void start_usart(uint32_t clock_hz)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_USART1EN);
    GPIOA->PUPDR |= 1u << (2 * 10);                            // an open wire is silent
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
    watch_supply();

    clock_on(&RCC->APB1ENR, RCC_APB1ENR_TIM2EN | RCC_APB1ENR_TIM5EN);
    EXTI->PR = 1u << STOP_PIN | 1u << FAULT_PIN; // of the pull-ups
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
        return BOARD_BYTES_LOST;
    }
    return (status & (USART_SR_PE | USART_SR_FE | USART_SR_NF)) == 0u ? byte : BOARD_NO_BYTE;
}

// --- interrupts ----------------------------------------------------------------------------------------------------

#define CONVERSIONS_MIN 4u // in a tick; 42 at 168 MHz, 8 at 16 MHz

static uint32_t adc_sum, adc_count; // of this tick, written in interrupts of one priority only

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
    *y = convert_sensor(sum, count);
    return true;
}

static void command(void *context, loop_force_t u)
{
    (void)context;
    DAC->DHR12R1 = convert_command(u);
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
    EXTI->PR             = edges; // cleared by writing ones; one that comes from here on stays for the next tick
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

/// A byte that the USART does not take in time is lost, and the next ones do not wait for it: the watchdog would bite.
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

const port_t board_port = {.context    = 0,
                           .read_force = read_force,
                           .command    = command,
                           .enable     = enable,
                           .inputs     = inputs,
                           .time_us    = time_us,
                           .log_byte   = log_byte};

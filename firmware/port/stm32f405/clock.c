#include "clock.h"

#include "wait.h"
#include "wiring.h"

#include <stddef.h>

#define HSI_HZ 16000000u

// Volatile, so that the compiler reads it from the image, where a test changes it.
const volatile uint32_t clock_hse_bypass = WIRING_HSE_BYPASS;

/// Switches to the internal oscillator, undivided, with crystal and PLL off, which a boot loader may have started.
static void start_internal(void)
{
    RCC->CR |= RCC_CR_HSION;
    (void)wait_for(&RCC->CR, RCC_CR_HSIRDY, RCC_CR_HSIRDY);
    RCC->CFGR = 0;
    (void)wait_for(&RCC->CFGR, RCC_CFGR_SWS, 0);
    RCC->CR &= ~(RCC_CR_CSSON | RCC_CR_PLLON | RCC_CR_HSEON);
    (void)wait_for(&RCC->CR, RCC_CR_HSERDY, 0);
}

/// Selects a crystal or a clock at OSC_IN. The chip accepts this only while HSE is off.
static void choose_hse(void)
{
    RCC->CR = clock_hse_bypass != 0u ? RCC->CR | RCC_CR_HSEBYP : RCC->CR & ~RCC_CR_HSEBYP;
}

// --- the crystal against the internal oscillator -------------------------------------------------------------------
//
//     crystal / 31 --> TIM11 channel 1, a capture every 8 edges
//     HSI 16 MHz ----> TIM11 counter

#define CRYSTAL_DIVIDER 31u
#define CAPTURE_EVERY   8u
#define CAPTURES        12u // 47,616 counts at 1 MHz: below the counter's 65,536
#define CRYSTAL_CYCLES                                                                                                 \
    (CRYSTAL_DIVIDER * CAPTURE_EVERY * CAPTURES) // cycles of the crystal while the counter counts HSI
#define CAPTURE_TURNS 1000u                      // turns of a wait; a capture takes 60 at 4 MHz

static bool next_capture(uint32_t *count)
{
    if (!wait_for_turns(&TIM11->SR, TIM_SR_CC1IF, TIM_SR_CC1IF, CAPTURE_TURNS))
    {
        return false;
    }
    *count = TIM11->CCR1; // reading clears CC1IF
    return (TIM11->SR & TIM_SR_CC1OF) == 0u;
}

/// Measures the crystal in kHz; 0 if nothing is counted. The chip must run on HSI, with the crystal on.
static uint32_t measure_crystal_khz(void)
{
    clock_on(&RCC->APB2ENR, RCC_APB2ENR_TIM11EN);
    RCC->CFGR |= CRYSTAL_DIVIDER << RCC_CFGR_RTCPRE_Pos;
    TIM11->OR    = TIM11_OR_TI1_HSE_RTC;
    TIM11->CCMR1 = TIM_CCMR1_CC1S_TI1 | TIM_CCMR1_IC1PSC_DIV8;
    TIM11->CCER  = TIM_CCER_CC1E;
    TIM11->PSC   = 0;
    TIM11->ARR   = UINT16_MAX;
    TIM11->EGR   = TIM_EGR_UG;
    TIM11->SR    = 0;
    TIM11->CR1   = TIM_CR1_CEN;

    uint32_t first = 0;
    uint32_t last  = 0;
    bool     ok    = next_capture(&first) && next_capture(&first); // the first capture may be old
    for (uint32_t i = 0; ok && i < CAPTURES; i++)
    {
        ok = next_capture(&last);
    }
    TIM11->CR1           = 0;
    const uint32_t count = (last - first) & UINT16_MAX;
    return ok && count != 0u ? CRYSTAL_CYCLES * (HSI_HZ / 1000u) / count : 0u;
}

/// Compares the crystal with the config's to 8 %, the internal oscillator's error over the chip's temperature range.
static bool is_the_crystal(uint32_t measured_khz, uint32_t crystal_hz)
{
    const uint32_t named_khz = crystal_hz / 1000u;
    const uint32_t room_khz  = named_khz / 100u * 8u;
    return measured_khz >= named_khz - room_khz && measured_khz <= named_khz + room_khz;
}

// --- the PLL -------------------------------------------------------------------------------------------------------

/// Switches to 168 MHz from the PLL: PLLM is `input_mhz`, the VCO runs at 336 MHz. Returns false, with the chip still on
/// HSI, if the PLL does not lock or the switch to it fails.
static bool start_pll(uint32_t input_mhz, uint32_t source)
{
    // The bus dividers come first. They act some cycles after the write, well before the PLL locks.
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
    // The flash needs 5 wait states at 168 MHz, so set them before the switch.
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

board_clock_t clock_start(uint32_t crystal_hz)
{
    board_clock_t clock = {.source = CLOCK_INTERNAL, .apb_hz = 84000000u};
    clock_on(&RCC->APB1ENR, RCC_APB1ENR_PWREN);
    PWR_CR |= PWR_CR_VOS;
    start_internal();
    choose_hse();
    RCC->CR |= RCC_CR_HSEON;
    if (wait_for(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY))
    {
        clock.crystal_khz = measure_crystal_khz();
        if (is_the_crystal(clock.crystal_khz, crystal_hz) &&
            start_pll(crystal_hz / CLOCK_CRYSTAL_STEP_HZ, RCC_PLLCFGR_PLLSRC_HSE))
        {
            RCC->CR |= RCC_CR_CSSON; // causes an NMI if the crystal stops, because all timers would slow down alike
            clock.source = CLOCK_CRYSTAL;
            return clock;
        }
        clock.source = is_the_crystal(clock.crystal_khz, crystal_hz) ? CLOCK_INTERNAL : CLOCK_WRONG;
    }
    RCC->CR &= ~RCC_CR_HSEON;
    if (!start_pll(16, 0))
    {
        RCC->CFGR    = 0; // undivided
        clock.source = CLOCK_SLOW;
        clock.apb_hz = HSI_HZ;
    }
    return clock;
}

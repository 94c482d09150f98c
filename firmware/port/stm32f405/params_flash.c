#include "params_flash.h"

#include "board.h"
#include "device.h"
#include "registers.h"

#include <stddef.h>

// From the linker script.
extern uint32_t store_start[];

#define SECTOR_WORDS (128u * 1024u / 4u)
#define FIRST_SECTOR 10u

// Time-outs of 5 s and 1 ms, in turns of the loop in RAM, which take at least 8 cycles at 168 MHz or less.
#define ERASE_TURNS 105000000u
#define WRITE_TURNS 21000u

/// Runs in RAM: starts the operation `control` of FLASH_CR and waits for its end. Writes `word` unless it is null. Kicks the
/// watchdog, because no other code runs; the time-out ends a flash that stays busy.
__attribute__((section(".ramcode"), noinline)) static bool run_in_ram(uint32_t           control,
                                                                      uint32_t           turns,
                                                                      volatile uint32_t *word,
                                                                      uint32_t           value)
{
    FLASH_CR = control;
    if (word != NULL)
    {
        *word = value;
    }
    else
    {
        FLASH_CR = control | FLASH_CR_STRT;
    }
    __DSB();
    while ((FLASH_SR & FLASH_SR_BSY) != 0u && turns > 0u)
    {
        IWDG->KR = IWDG_KR_RELOAD;
        turns--;
    }
    return turns > 0u;
}

/// Stops the drive's timers, unlocks the flash and makes RAM executable for one operation. The power stage must be off.
static bool operate(uint32_t control, uint32_t turns, volatile uint32_t *word, uint32_t value)
{
    if (!board_is_off())
    {
        return false; // an erasure stops the tick
    }
    bool (*volatile in_ram)(uint32_t, uint32_t, volatile uint32_t *, uint32_t) =
        run_in_ram; // a pointer, because RAM is too far for a direct call

    const uint32_t mask = __get_PRIMASK();
    const uint32_t mpu  = MPU->CTRL;
    const uint32_t tick = TIM2->CR1;
    const uint32_t time = TIM5->CR1;
    TIM2->CR1           = tick & ~TIM_CR1_CEN;
    TIM5->CR1           = time & ~TIM_CR1_CEN;
    __disable_irq();
    MPU->CTRL = 0;
    __DSB();
    __ISB();

    FLASH_SR        = FLASH_SR_ERRORS; // writing ones clears the bits
    FLASH_KEYR      = FLASH_KEY1;
    FLASH_KEYR      = FLASH_KEY2;
    const bool open = (FLASH_CR & FLASH_CR_LOCK) == 0u;
    const bool done = open && in_ram(control, turns, word, value) && (FLASH_SR & FLASH_SR_ERRORS) == 0u;
    FLASH_CR        = FLASH_CR_LOCK;
    // The caches may hold outdated contents of the flash.
    const uint32_t caches = FLASH_ACR & (FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    FLASH_ACR &= ~caches;
    FLASH_ACR |= FLASH_ACR_DCRST | FLASH_ACR_ICRST;
    FLASH_ACR &= ~(FLASH_ACR_DCRST | FLASH_ACR_ICRST);
    FLASH_ACR |= caches;

    MPU->CTRL = mpu;
    __DSB();
    __ISB();
    TIM2->CR1 =
        tick; // the timers start in the order of their stop, so that both stand still for as long and no tick is late
    TIM5->CR1 = time;
    __set_PRIMASK(mask);
    return done;
}

static volatile uint32_t *word_at(unsigned sector, uint32_t word)
{
    return store_start + sector * SECTOR_WORDS + word;
}

static uint32_t read_word(void *context, unsigned sector, uint32_t word)
{
    (void)context;
    return *word_at(sector, word);
}

static bool erase(void *context, unsigned sector)
{
    (void)context;
    return operate(FLASH_CR_PSIZE_X32 | FLASH_CR_SER | (FIRST_SECTOR + sector) << FLASH_CR_SNB_Pos,
                   ERASE_TURNS,
                   NULL,
                   0);
}

static bool write_word(void *context, unsigned sector, uint32_t word, uint32_t value)
{
    (void)context;
    return operate(FLASH_CR_PSIZE_X32 | FLASH_CR_PG, WRITE_TURNS, word_at(sector, word), value);
}

const store_flash_t params_flash = {.sector_words = SECTOR_WORDS,
                                    .read         = read_word,
                                    .erase        = erase,
                                    .write        = write_word};

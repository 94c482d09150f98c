#include "reset.h"

#include "board.h"
#include "device.h"
#include "registers.h"

#define RECORD_MAGIC 0x54455352u // "RSET"

/// The record is in RAM that start-up does not clear. Its contents are random after a loss of supply, so it has a checksum.
typedef struct
{
    uint32_t magic;
    reset_t  reset;
    uint32_t seal;
} record_t;

__attribute__((section(".noinit"))) static volatile record_t record;

static uint32_t seal_of(const reset_t *reset)
{
    return ~(RECORD_MAGIC + (uint32_t)reset->cause + reset->exception + reset->address + reset->status);
}

reset_t reset_take(void)
{
    const uint32_t flags = RCC->CSR;
    reset_t        reset = record.reset;
    const bool     valid = record.magic == RECORD_MAGIC && record.seal == seal_of(&reset);
    RCC->CSR |= RCC_CSR_RMVF;
    record.magic = 0;

    // The chip pulls its own reset pin, so the pin's flag accompanies every other.
    if ((flags & RCC_CSR_PORRSTF) != 0u)
    {
        return (reset_t){.cause = RESET_POWER_ON};
    }
    if (valid && (flags & (RCC_CSR_SFTRSTF | RCC_CSR_IWDGRSTF)) != 0u)
    {
        return reset;
    }
    if ((flags & (RCC_CSR_IWDGRSTF | RCC_CSR_WWDGRSTF)) != 0u)
    {
        return (reset_t){.cause = RESET_WATCHDOG};
    }
    if ((flags & RCC_CSR_SFTRSTF) != 0u)
    {
        return (reset_t){.cause = RESET_SOFTWARE};
    }
    return (reset_t){.cause = (flags & RCC_CSR_BORRSTF) != 0u ? RESET_BROWN_OUT : RESET_PIN};
}

drive_fault_t reset_fault(reset_cause_t cause)
{
    static const drive_fault_t faults[] = {[RESET_POWER_ON]  = DRIVE_FAULT_NONE,
                                           [RESET_PIN]       = DRIVE_FAULT_NONE,
                                           [RESET_BROWN_OUT] = DRIVE_FAULT_BROWN_OUT,
                                           [RESET_WATCHDOG]  = DRIVE_FAULT_WATCHDOG,
                                           [RESET_EXCEPTION] = DRIVE_FAULT_EXCEPTION,
                                           [RESET_CRYSTAL]   = DRIVE_FAULT_CRYSTAL,
                                           [RESET_SOFTWARE]  = DRIVE_FAULT_RESTART};
    return faults[cause];
}

drive_fault_t reset_check_brown_out(void)
{
    return (FLASH_OPTCR & FLASH_OPTCR_BOR_LEV) == FLASH_OPTCR_BOR_LEV_2V7 ? DRIVE_FAULT_NONE
                                                                          : DRIVE_FAULT_BROWN_OUT_LEVEL;
}

void reset_now(const reset_t *reset)
{
    board_off();
    record.reset = *reset;
    record.seal  = seal_of(reset);
    record.magic = RECORD_MAGIC;
    __DSB();
    NVIC_SystemReset();
}

const char *reset_text(reset_cause_t cause)
{
    static const char *const texts[] = {[RESET_POWER_ON]  = "power-on",
                                        [RESET_PIN]       = "pin",
                                        [RESET_BROWN_OUT] = "low supply",
                                        [RESET_WATCHDOG]  = "watchdog",
                                        [RESET_EXCEPTION] = "exception",
                                        [RESET_CRYSTAL]   = "crystal stopped",
                                        [RESET_SOFTWARE]  = "software"};
    return texts[cause];
}

/// Finds why the chip was reset, from the reset flags and from a record in RAM that survives a reset.

#ifndef STM32F405_RESET_H
#define STM32F405_RESET_H

#include "app/drive.h"

#include <stdint.h>

typedef enum
{
    RESET_POWER_ON,
    RESET_PIN,       ///< the reset button or a debugger's reset line
    RESET_BROWN_OUT, ///< the supply fell below the brown-out level, but not to 0
    RESET_WATCHDOG,  ///< a tick or the background hung
    RESET_EXCEPTION, ///< a hard fault, or an exception without a handler
    RESET_CRYSTAL,   ///< the crystal stopped
    RESET_SOFTWARE   ///< a debugger, or a request that left no record
} reset_cause_t;

typedef struct
{
    reset_cause_t cause;
    uint32_t      exception; ///< number of the exception, as in PM0214: 3 is a hard fault
    uint32_t      address;   ///< address of the interrupted instruction, or 0 if the stack is lost
    uint32_t      status;    ///< CFSR of a hard fault: bit 4 is a stack overflow
} reset_t;

/// Reads flags and record and clears both, so that the next reset shows its own cause. Call it once, before RAM is tested.
reset_t reset_take(void);

/// Returns the drive's initial fault.
drive_fault_t reset_fault(reset_cause_t cause);

/// Returns whether the option bytes let the chip run on with a supply at which neither flash nor converters are reliable.
/// Their level must be the highest, 2.7 V.
drive_fault_t reset_check_brown_out(void);

/// Leaves a record and resets the chip, with the outputs off. Does not return.
void reset_now(const reset_t *reset);

const char *reset_text(reset_cause_t cause);

#endif

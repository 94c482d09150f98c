/// The flash behind the drive's store of params: the chip's last two sectors, of 128 KiB each (RM0090, 3).
///
/// While a sector is erased, for 1 to 4 s, or a word is written, for 16 to 100 us, no code can be fetched from flash. The
/// drive pauses then: TIM2 and TIM5 stop, interrupts are off, and code in RAM kicks the watchdog. The drive must be off,
/// because nothing reacts during an erasure, not even to the emergency stop.

#ifndef STM32F405_PARAMS_FLASH_H
#define STM32F405_PARAMS_FLASH_H

#include "app/store.h"

extern const store_flash_t params_flash;

#endif

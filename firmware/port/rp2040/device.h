/// The core's registers from CMSIS-Core, with the facts about the RP2040 that it needs.

#ifndef RP2040_DEVICE_H
#define RP2040_DEVICE_H

/// Exceptions of the Cortex-M0+, and the interrupts that this port uses.
typedef enum
{
    NonMaskableInt_IRQn = -14,
    HardFault_IRQn      = -13,
    SVCall_IRQn         = -5,
    PendSV_IRQn         = -2,
    SysTick_IRQn        = -1,
    TIMER_0_IRQn        = 0,
    IO_BANK0_IRQn       = 13
} IRQn_Type;

#define __CM0PLUS_REV          0x0001U
#define __MPU_PRESENT          0U // the chip has an MPU, but this port does not use it
#define __VTOR_PRESENT         1U
#define __NVIC_PRIO_BITS       2U
#define __Vendor_SysTickConfig 0U

#include "core_cm0plus.h"

#endif

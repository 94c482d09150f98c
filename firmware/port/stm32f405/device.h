/// The core's registers from CMSIS-Core, with the facts about the STM32F405 that it needs (RM0090, PM0214).

#ifndef STM32F405_DEVICE_H
#define STM32F405_DEVICE_H

/// Exceptions of the Cortex-M4, and the interrupts that this port uses.
typedef enum
{
    NonMaskableInt_IRQn   = -14,
    HardFault_IRQn        = -13,
    MemoryManagement_IRQn = -12,
    BusFault_IRQn         = -11,
    UsageFault_IRQn       = -10,
    SVCall_IRQn           = -5,
    DebugMonitor_IRQn     = -4,
    PendSV_IRQn           = -2,
    SysTick_IRQn          = -1,
    PVD_IRQn              = 1,
    EXTI1_IRQn            = 7,
    ADC_IRQn              = 18,
    TIM2_IRQn             = 28,
    USART1_IRQn           = 37,
    EXTI15_10_IRQn        = 40
} IRQn_Type;

#define __CM4_REV              0x0001U // r0p1
#define __MPU_PRESENT          1U
#define __NVIC_PRIO_BITS       4U
#define __Vendor_SysTickConfig 0U
#define __FPU_PRESENT          1U

#include "core_cm4.h"

#endif

// From reset to main: vector table, initialised memory, FPU.

#include "board.h"
#include "device.h"
#include "registers.h"

#include <stddef.h>

extern uint32_t       data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern const uint32_t data_source[];

int main(void);

void Reset_Handler(void);
void Default_Handler(void);
void TIM2_IRQHandler(void);
void ADC_IRQHandler(void);

/// Unexpected exceptions, a stopped crystal (NMI) and a low supply (PVD): the outputs go off and stay off until the watchdog
/// resets the chip; the drive then waits in FAULT for an acknowledgement (in IDLE after a loss of supply).
void Default_Handler(void)
{
    board_off();
    IWDG->KR = IWDG_KR_START; // in case it does not run yet
    for (;;)
    {
    }
}

void Reset_Handler(void)
{
    SCB->CPACR |= 0xfu << 20; // CP10 and CP11: the FPU, before any float
    __DSB();
    __ISB();
    const uint32_t *source = data_source;
    for (uint32_t *word = data_start; word < data_end; word++)
    {
        *word = *source++;
    }
    for (uint32_t *word = bss_start; word < bss_end; word++)
    {
        *word = 0;
    }
    (void)main();
    Default_Handler();
}

typedef void (*handler_t)(void);

#define CORE_VECTORS 16

/// Exceptions 1 to 15, then the chip's interrupts. Default_Handler handles all that have no handler of their own.
typedef struct
{
    const void *stack;
    handler_t   exceptions[CORE_VECTORS - 1];
    handler_t   interrupts[82];
} vectors_t;

#define UP_TO_17                                                                                                       \
    Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler,              \
        Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler,          \
        Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler
#define NINE                                                                                                           \
    Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler, Default_Handler,              \
        Default_Handler, Default_Handler, Default_Handler

__attribute__((section(".vectors"), used)) const vectors_t vectors = {.stack      = stack_top,
                                                                      .exceptions = {Reset_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     NULL,
                                                                                     NULL,
                                                                                     NULL,
                                                                                     NULL,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     NULL,
                                                                                     Default_Handler,
                                                                                     Default_Handler},
                                                                      // 0 to 17, ADC, 19 to 27, TIM2, 29 to 81
                                                                      .interrupts = {UP_TO_17,
                                                                                     ADC_IRQHandler,
                                                                                     NINE,
                                                                                     TIM2_IRQHandler,
                                                                                     NINE,
                                                                                     NINE,
                                                                                     NINE,
                                                                                     NINE,
                                                                                     NINE,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler,
                                                                                     Default_Handler}};

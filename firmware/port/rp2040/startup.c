// The way from the second stage to main: vector table and initialised memory. Also the exceptions that reset the chip.

#include "board.h"
#include "device.h"

#include <stddef.h>

extern uint32_t       data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern const uint32_t data_source[];

int main(void);

typedef void (*handler_t)(void);

#define CORE_VECTORS 16
#define INTERRUPTS   26

typedef struct
{
    const void *stack;
    handler_t   exceptions[CORE_VECTORS - 1];
    handler_t   interrupts[INTERRUPTS];
} vectors_t;

extern const vectors_t vectors;

void Reset_Handler(void);
void Exception_Handler(void);
void startup_end(const uint32_t *frame);
void TIMER_0_IRQHandler(void);
void IO_BANK0_IRQHandler(void);

#define FRAME_PC 6 // place of the PC among the words that an exception pushes

/// Handles a hard fault or an exception without a handler: turns the outputs off, then resets with a record of the place.
__attribute__((used)) void startup_end(const uint32_t *frame)
{
    board_reset(__get_IPSR(), frame[FRAME_PC]);
}

/// Passes the address of the exception's frame. It is not written in C, because a prologue would move the stack pointer.
__attribute__((naked)) void Exception_Handler(void)
{
    __asm volatile("mov r0, sp\n bl startup_end");
}

void Reset_Handler(void)
{
    __disable_irq();
    SysTick->CTRL = 0;
    NVIC->ICER[0] = UINT32_MAX;
    NVIC->ICPR[0] = UINT32_MAX;
    __enable_irq(); // no interrupt is enabled yet
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
    board_reset(0, 0);
}

#define X   Exception_Handler
#define SIX X, X, X, X, X, X

__attribute__((section(".vectors"), used)) const vectors_t vectors = {
    .stack      = stack_top,
    .exceptions = {Reset_Handler, X, X, NULL, NULL, NULL, NULL, NULL, NULL, NULL, X, NULL, NULL, X, X},
    .interrupts = {TIMER_0_IRQHandler, SIX, SIX, IO_BANK0_IRQHandler, SIX, SIX}};

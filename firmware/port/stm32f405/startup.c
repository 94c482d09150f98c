// The way from reset to main: vector table, initialised memory, FPU. Also the exceptions that reset the chip.

#include "device.h"
#include "registers.h"
#include "reset.h"

#include <stddef.h>

extern uint32_t       data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern const uint32_t data_source[];

int main(void);

typedef void (*handler_t)(void);

#define CORE_VECTORS 16

/// Exceptions 1 to 15, then the chip's interrupts.
typedef struct
{
    const void *stack;
    handler_t   exceptions[CORE_VECTORS - 1];
    handler_t   interrupts[82];
} vectors_t;

extern const vectors_t vectors;

void Reset_Handler(void);
void NMI_Handler(void);
void Exception_Handler(void);
void startup_end(const uint32_t *frame);
void EXTI1_IRQHandler(void);
void EXTI15_10_IRQHandler(void);
void PVD_IRQHandler(void);
void TIM2_IRQHandler(void);
void ADC_IRQHandler(void);
void USART1_IRQHandler(void);

#define FRAME_PC 6 // place of the PC among the words that an exception pushes

/// Handles a hard fault or an exception without a handler: turns the outputs off, then resets with a record of the place.
__attribute__((used)) void startup_end(const uint32_t *frame)
{
    const uint32_t status  = SCB->CFSR;
    const bool     stacked = (status & (SCB_CFSR_MSTKERR_Msk | SCB_CFSR_STKERR_Msk)) == 0u;
    const reset_t  reset   = {.cause     = RESET_EXCEPTION,
                              .exception = __get_IPSR(),
                              .address   = stacked ? frame[FRAME_PC] : 0u,
                              .status    = status};
    reset_now(&reset);
}

/// Passes the address of the exception's frame. It is not written in C, because a prologue would move the stack pointer.
__attribute__((naked)) void Exception_Handler(void)
{
    __asm volatile("mov r0, sp\n b startup_end");
}

void NMI_Handler(void)
{
    const bool crystal = (RCC->CIR & RCC_CIR_CSSF) != 0u;
    RCC->CIR |= RCC_CIR_CSSC;
    const reset_t reset = {.cause = crystal ? RESET_CRYSTAL : RESET_EXCEPTION, .exception = __get_IPSR()};
    reset_now(&reset);
}

#define NVIC_WORDS 3 // words for the chip's 82 interrupts

void Reset_Handler(void)
{
    // A boot loader leaves its vectors, and perhaps enabled interrupts.
    __disable_irq();
    SysTick->CTRL = 0;
    for (unsigned i = 0; i < NVIC_WORDS; i++)
    {
        NVIC->ICER[i] = UINT32_MAX;
        NVIC->ICPR[i] = UINT32_MAX;
    }
    SCB->VTOR = (uint32_t)&vectors;
    SCB->CPACR |= 0xfu << 20; // CP10 and CP11: the FPU, before any float
    __DSB();
    __ISB();
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
    const reset_t reset = {.cause = RESET_SOFTWARE};
    reset_now(&reset);
}

// The chip's interrupts: those without a handler of their own end in Exception_Handler.
#define X     Exception_Handler
#define FIVE  X, X, X, X, X
#define EIGHT FIVE, X, X, X
#define NINE  EIGHT, X

__attribute__((section(".vectors"), used)) const vectors_t vectors = {
    .stack      = stack_top,
    .exceptions = {Reset_Handler, NMI_Handler, X, X, X, X, NULL, NULL, NULL, NULL, X, X, NULL, X, X},
    .interrupts = {X, // 0
                   PVD_IRQHandler,
                   FIVE, // 2 to 6
                   EXTI1_IRQHandler,
                   FIVE, // 8 to 17
                   FIVE,
                   ADC_IRQHandler,
                   NINE, // 19 to 27
                   TIM2_IRQHandler,
                   EIGHT, // 29 to 36
                   USART1_IRQHandler,
                   X, // 38 and 39
                   X,
                   EXTI15_10_IRQHandler,
                   NINE, // 41 to 81
                   NINE,
                   NINE,
                   NINE,
                   FIVE}};

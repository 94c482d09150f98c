// Takes any Cortex-M from reset to a 1 kHz tick: sets up vectors, memory, FPU and SysTick.

#include "board.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define SYST_CSR          REGISTER(0xe000e010u)
#define SYST_RVR          REGISTER(0xe000e014u)
#define SYST_CVR          REGISTER(0xe000e018u)
#define SCB_ICSR          REGISTER(0xe000ed04u)
#define SCB_CPACR         REGISTER(0xe000ed88u)
#define ICSR_PENDSTSET    (1u << 26)

extern uint32_t       data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern const uint32_t data_source[];

void reset_handler(void);
void fault_handler(void);
void systick_handler(void);

void reset_handler(void)
{
    const uint32_t *source = data_source;
    for (uint32_t *word = data_start; word < data_end; word++)
    {
        *word = *source++;
    }
    for (uint32_t *word = bss_start; word < bss_end; word++)
    {
        *word = 0;
    }
#ifdef __ARM_FP
    SCB_CPACR |= 0xfu << 20;
    __asm volatile("dsb\n isb" ::: "memory");
#endif
    loop_start();
    SYST_RVR = BOARD_CORE_HZ / 1000u - 1u;
    SYST_CVR = 0;
    SYST_CSR = 7; // enabled, with interrupt, clocked by the core
    for (;;)
    {
        __asm volatile("wfi");
    }
}

void fault_handler(void)
{
    board_off();
    for (;;)
    {
    }
}

void systick_handler(void)
{
    loop_tick();
    const bool late =
        (SCB_ICSR & ICSR_PENDSTSET) != 0u; // the next tick is already due: the loop is too slow for its rate
    if (late || !board_is_healthy())
    {
        board_off();
    }
}

typedef void (*handler_t)(void);

__attribute__((section(".vectors"), used)) static const struct
{
    const uint32_t *stack;
    handler_t       exceptions[15];
} vectors = {stack_top,
             {reset_handler,
              fault_handler,
              fault_handler,
              fault_handler,
              fault_handler,
              fault_handler,
              0,
              0,
              0,
              0,
              fault_handler,
              fault_handler,
              0,
              fault_handler,
              systick_handler}};

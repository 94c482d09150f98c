// The drive on the STM32F405 in lock-step with the host over USART1 at 921,600 baud, for a bare board without a rig. The outputs
// stay off. DWT counts the cycles.

#include "port/emulated/lock_step.h"

#include "app/scaling.h"
#include "board.h"
#include "convert.h"
#include "device.h"
#include "port/serial/serial.h"
#include "registers.h"
#include "rig_config.h"

#define BAUD 921600u

extern uint32_t data_start[];

/// The interrupt of the tick, which never comes because no timer is started.
void board_tick(void)
{
}

uint8_t serial_read(void)
{
    for (;;)
    {
        const int byte = board_read_byte();
        if (byte >= 0)
        {
            return (uint8_t)byte;
        }
    }
}

void serial_write(uint8_t byte)
{
    while ((USART1->SR & USART_SR_TXE) == 0u)
    {
    }
    USART1->DR = byte;
}

uint32_t serial_cycles(void)
{
    return DWT->CYCCNT;
}

uint32_t *serial_ram(void)
{
    return data_start;
}

int main(void)
{
    const board_clock_t clock = board_init(&rig_config, scaling_number(rig_config.command_zero_units, CONVERT_CODES));
    USART1->BRR               = (clock.apb_hz + BAUD / 2u) / BAUD;
    CoreDebug->DEMCR |= CoreDebug_DEMCR_TRCENA_Msk;
    DWT->CYCCNT = 0;
    DWT->CTRL |= DWT_CTRL_CYCCNTENA_Msk;
    for (;;)
    {
        (void)lock_step();
    }
}

/// Sets up the chip's clock: 168 MHz from the crystal, which is first checked against the internal oscillator. A clock at OSC_IN
/// (wiring.h) counts as a crystal, here and in the config.

#ifndef STM32F405_CLOCK_H
#define STM32F405_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

typedef enum
{
    CLOCK_CRYSTAL, ///< 168 MHz from the config's crystal
    CLOCK_INTERNAL, ///< 168 MHz from the internal oscillator (HSI): the crystal does not start. 1 % off at 25 C, 8 % in the cold
    CLOCK_SLOW, ///< 16 MHz, the internal oscillator itself: the PLL does not lock
    CLOCK_WRONG ///< 168 MHz from the internal oscillator: the crystal runs, but is not the config's
} clock_source_t;

typedef struct
{
    clock_source_t source;
    uint32_t       crystal_khz; ///< measured to 8 %, the error of the internal oscillator; 0: it does not run
    uint32_t       apb_hz;      ///< clock of USART1, TIM2 and TIM5
} board_clock_t;

#define CLOCK_CRYSTAL_STEP_HZ 1000000u ///< the PLL's input is 1 MHz, so a crystal must be a multiple of it

/// Starts the clock from any state. Every failure ends on a slower or less accurate clock. If the crystal stops later, an NMI
/// occurs.
board_clock_t clock_start(uint32_t crystal_hz);

#endif

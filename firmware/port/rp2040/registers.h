/// The only registers of the RP2040 that this port touches, named as in its datasheet. The core's own registers are CMSIS-Core's
/// (device.h).

#ifndef RP2040_REGISTERS_H
#define RP2040_REGISTERS_H

#include <stdint.h>

typedef volatile uint32_t reg_t;

#define REGISTERS_SET 0x2000u ///< added to a register's address: a write sets the written bits ...
#define REGISTERS_CLR 0x3000u ///< ... or clears them

static inline void registers_set(reg_t *of, uint32_t bits)
{
    *(reg_t *)((uintptr_t)of + REGISTERS_SET) = bits; // NOLINT(performance-no-int-to-ptr)
}

static inline void registers_clear(reg_t *of, uint32_t bits)
{
    *(reg_t *)((uintptr_t)of + REGISTERS_CLR) = bits; // NOLINT(performance-no-int-to-ptr)
}

// --- SSI: the flash in place ---------------------------------------------------------------------------------------

typedef struct
{
    reg_t CTRLR0, CTRLR1, SSIENR, MWCR, SER, BAUDR;
} ssi_t;

#define SSI            ((ssi_t *)0x18000000u)
#define SSI_SPI_CTRLR0 (*(reg_t *)0x180000f4u)

#define SSI_CTRLR0_TMOD_EEPROM     (3u << 8) ///< writes instruction and address, then reads
#define SSI_CTRLR0_DFS_32_BITS     (31u << 16)
#define SSI_SPI_CTRLR0_ADDR_24     (6u << 2) ///< in units of 4 bits
#define SSI_SPI_CTRLR0_INST_8      (2u << 8)
#define SSI_SPI_CTRLR0_XIP_CMD_Pos 24

// --- clocks --------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t CTRL, DIV, SELECTED;
} clock_t;

#define CLK_REF  ((clock_t *)0x40008030u)
#define CLK_SYS  ((clock_t *)0x4000803cu)
#define CLK_PERI ((clock_t *)0x40008048u)
#define CLK_ADC  ((clock_t *)0x40008060u)

#define CLK_REF_CTRL_XOSC (2u << 0)
#define CLK_SYS_CTRL_AUX  (1u << 0) ///< AUXSRC 0 is the system's PLL
#define CLK_CTRL_ENABLE   (1u << 11)

#define XOSC_CTRL    (*(reg_t *)0x40024000u)
#define XOSC_STATUS  (*(reg_t *)0x40024004u)
#define XOSC_STARTUP (*(reg_t *)0x4002400cu)

#define XOSC_CTRL_1_15MHZ  0xaa0u
#define XOSC_CTRL_ENABLE   (0xfabu << 12)
#define XOSC_STATUS_STABLE (1u << 31)

typedef struct
{
    reg_t CS, PWR, FBDIV_INT, PRIM;
} pll_t;

#define PLL_SYS ((pll_t *)0x40028000u)
#define PLL_USB ((pll_t *)0x4002c000u)

#define PLL_CS_LOCK           (1u << 31)
#define PLL_PWR_PD            (1u << 0)
#define PLL_PWR_POSTDIVPD     (1u << 3)
#define PLL_PWR_VCOPD         (1u << 5)
#define PLL_PRIM_POSTDIV1_Pos 16
#define PLL_PRIM_POSTDIV2_Pos 12

// --- resets --------------------------------------------------------------------------------------------------------

#define RESETS_RESET      (*(reg_t *)0x4000c000u)
#define RESETS_RESET_DONE (*(reg_t *)0x4000c008u)

#define RESETS_ADC        (1u << 0)
#define RESETS_IO_BANK0   (1u << 5)
#define RESETS_PADS_BANK0 (1u << 8)
#define RESETS_PLL_SYS    (1u << 12)
#define RESETS_PLL_USB    (1u << 13)
#define RESETS_PWM        (1u << 14)
#define RESETS_TIMER      (1u << 21)
#define RESETS_UART0      (1u << 22)

#define PSM_WDSEL     (*(reg_t *)0x40010008u)
#define PSM_WDSEL_ALL 0x1fffcu ///< everything except the two oscillators

// --- pins ----------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t STATUS, CTRL;
} io_t;

#define IO_BANK0             ((io_t *)0x40014000u) ///< one row for each pin
#define IO_BANK0_INTR0       (*(reg_t *)0x400140f0u)
#define IO_BANK0_PROC0_INTE0 (*(reg_t *)0x40014100u)
#define IO_EDGE_LOW(pin)     (4u << (4u * (pin))) ///< for pins 0 to 7
#define IO_EDGE_HIGH(pin)    (8u << (4u * (pin)))
#define IO_CTRL_UART         2u
#define IO_CTRL_PWM          4u
#define IO_CTRL_SIO          5u
#define IO_CTRL_NONE         31u
#define IO_CTRL_OUTOVER_LOW  (2u << 8)

#define PADS_BANK0 ((reg_t *)0x4001c004u) ///< one row for each pin

#define PADS_SCHMITT (1u << 1)
#define PADS_PDE     (1u << 2)
#define PADS_PUE     (1u << 3)
#define PADS_4MA     (1u << 4)
#define PADS_IE      (1u << 6)
#define PADS_OD      (1u << 7)

typedef struct
{
    reg_t CPUID, GPIO_IN, GPIO_HI_IN, reserved_0c, GPIO_OUT, GPIO_OUT_SET, GPIO_OUT_CLR, GPIO_OUT_XOR;
    reg_t GPIO_OE, GPIO_OE_SET, GPIO_OE_CLR;
} sio_t;

#define SIO ((sio_t *)0xd0000000u)

// --- PWM -----------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t CSR, DIV, CTR, CC, TOP;
} pwm_t;

#define PWM ((pwm_t *)0x40050000u) ///< one row for each slice

#define PWM_CSR_EN (1u << 0)

// --- ADC -----------------------------------------------------------------------------------------------------------

#define ADC_CS     (*(reg_t *)0x4004c000u)
#define ADC_RESULT (*(reg_t *)0x4004c004u)

#define ADC_CS_EN         (1u << 0)
#define ADC_CS_START      (1u << 2)
#define ADC_CS_READY      (1u << 8)
#define ADC_CS_ERR        (1u << 9)
#define ADC_CS_AINSEL_Pos 12

// --- UART0 ---------------------------------------------------------------------------------------------------------

typedef struct
{
    reg_t DR, RSR, reserved_08[4], FR, reserved_1c[2], IBRD, FBRD, LCR_H, CR, IFLS, IMSC, RIS, MIS, ICR;
} uart_t;

#define UART0 ((uart_t *)0x40034000u)

#define UART_DR_ERRORS 0xf00u
#define UART_FR_BUSY   (1u << 3)
#define UART_FR_RXFE   (1u << 4)
#define UART_FR_TXFF   (1u << 5)
#define UART_LCR_H_8   (3u << 5)
#define UART_LCR_H_FEN (1u << 4)
#define UART_CR_UARTEN (1u << 0)
#define UART_CR_TXE    (1u << 8)
#define UART_CR_RXE    (1u << 9)

// --- TIMER and WATCHDOG --------------------------------------------------------------------------------------------

#define TIMER_ALARM0   (*(reg_t *)0x40054010u)
#define TIMER_TIMERAWL (*(reg_t *)0x40054028u)
#define TIMER_INTR     (*(reg_t *)0x40054034u)
#define TIMER_INTE     (*(reg_t *)0x40054038u)

#define TIMER_INT_ALARM0 (1u << 0)

typedef struct
{
    reg_t CTRL, LOAD, REASON, SCRATCH[8], TICK;
} watchdog_t;

#define WATCHDOG ((watchdog_t *)0x40058000u)

#define WATCHDOG_CTRL_ENABLE  (1u << 30)
#define WATCHDOG_CTRL_TRIGGER (1u << 31)
#define WATCHDOG_REASON_TIMER (1u << 0)
#define WATCHDOG_TICK_ENABLE  (1u << 9)

#endif

// The second stage of the boot loader. The boot ROM copies the first 256 bytes of flash into RAM, checks their CRC (written
// by firmware/tools/rp2040_image.py) and calls them. They make the flash readable in place with 03h, the only command that
// every serial flash has, and start the image behind them. Reading is slow, one bit at a time, but goes through the chip's
// cache.

#include "registers.h"

#define READ_COMMAND  0x03u
#define CLOCK_DIVIDER 4u // must be even: 125 MHz become 31 MHz; 03h works up to 50 MHz or more

#define VTOR (*(reg_t *)0xe000ed08u)

extern const uint32_t vectors[];

void boot2(void);

/// Runs at any address, because it calls nothing and reads its constants relative to itself.
__attribute__((section(".boot2"), used, noreturn)) void boot2(void)
{
    SSI->SSIENR    = 0; // disabled while it is set up
    SSI->BAUDR     = CLOCK_DIVIDER;
    SSI->CTRLR0    = SSI_CTRLR0_DFS_32_BITS | SSI_CTRLR0_TMOD_EEPROM;
    SSI->CTRLR1    = 0; // one word for each read
    SSI_SPI_CTRLR0 = READ_COMMAND << SSI_SPI_CTRLR0_XIP_CMD_Pos | SSI_SPI_CTRLR0_INST_8 | SSI_SPI_CTRLR0_ADDR_24;
    SSI->SSIENR    = 1;
    VTOR           = (uint32_t)vectors;
    __asm volatile("msr msp, %0\n bx %1" : : "r"(vectors[0]), "r"(vectors[1]));
    __builtin_unreachable();
}

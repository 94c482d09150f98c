#include "app/crc16.h"

uint16_t crc16(const uint8_t *bytes, size_t size)
{
    // Four bits at a time, as in crc32.c.
    static const uint16_t table[16] = {0x0000u,
                                       0xcc01u,
                                       0xd801u,
                                       0x1400u,
                                       0xf001u,
                                       0x3c00u,
                                       0x2800u,
                                       0xe401u,
                                       0xa001u,
                                       0x6c00u,
                                       0x7800u,
                                       0xb401u,
                                       0x5000u,
                                       0x9c01u,
                                       0x8801u,
                                       0x4400u};

    uint32_t crc = 0xffffu;
    for (size_t i = 0; i < size; i++)
    {
        crc ^= bytes[i];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return (uint16_t)crc;
}

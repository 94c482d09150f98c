/// CRC-16 of Modbus RTU (reflected, polynomial 0xA001, initial value 0xFFFF): 0x4B37 for "123456789". The low byte is sent first.

#ifndef DRIVE_CRC16_H
#define DRIVE_CRC16_H

#include <stddef.h>
#include <stdint.h>

uint16_t crc16(const uint8_t *bytes, size_t size);

#endif

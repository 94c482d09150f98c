/// CRC-32 of IEEE 802.3 (reflected, polynomial 0xEDB88320): 0xCBF43926 for "123456789".

#ifndef DRIVE_CRC32_H
#define DRIVE_CRC32_H

#include <stddef.h>
#include <stdint.h>

/// Returns the CRC of the data so far, `crc`, followed by `data`. Pass 0 as the first `crc`.
uint32_t crc32_update(uint32_t crc, const void *data, size_t size);

#endif

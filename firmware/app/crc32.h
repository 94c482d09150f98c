/// CRC-32 as of IEEE 802.3 (reflected, 0xEDB88320), e.g. 0xCBF43926 of "123456789".

#ifndef DRIVE_CRC32_H
#define DRIVE_CRC32_H

#include <stddef.h>
#include <stdint.h>

/// Goes on from `crc`, which is 0 at the start.
uint32_t crc32_update(uint32_t crc, const void *data, size_t size);

#endif

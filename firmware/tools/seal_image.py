#!/usr/bin/env python3
"""seal_image.py IMAGE.elf: writes the CRC of the image into its selftest_seal (firmware/app/selftest.h).

The CRC is over everything that is loaded, at the address it is loaded to, but for the seal itself.
"""

import pathlib
import struct
import sys
import zlib

MAGIC = 0x4C414553
REGIONS = 4
SEAL_SIZE = 8 + 8 * REGIONS
PT_LOAD, SHT_SYMTAB = 1, 2


def fail(message):
    sys.exit(f"seal_image.py: {message}")


def load_segments(elf):
    """(load address, virtual address, file offset, size) of each loaded segment, by load address."""
    table, entry_size, count = struct.unpack_from("<I10xHH", elf, 28)
    segments = []
    for i in range(count):
        kind, offset, virtual, physical, size = struct.unpack_from("<5I", elf, table + i * entry_size)
        if kind == PT_LOAD and size > 0:
            segments.append((physical, virtual, offset, size))
    return sorted(segments)


def symbol_value(elf, name):
    """Address and size of a symbol."""
    table, entry_size, count = struct.unpack_from("<I10xHH", elf, 32)
    sections = [struct.unpack_from("<10I", elf, table + i * entry_size) for i in range(count)]
    for section in sections:
        if section[1] != SHT_SYMTAB:
            continue
        names = sections[section[6]][4]
        for at in range(section[4], section[4] + section[5], 16):
            start, value, size = struct.unpack_from("<3I", elf, at)
            if elf[names + start:elf.index(b"\0", names + start)] == name:
                return value, size
    return fail(f"no symbol {name.decode()}")


def seal(path):
    elf = bytearray(path.read_bytes())
    if elf[:6] != b"\x7fELF\x01\x01":
        fail(f"{path}: not a 32-bit little-endian ELF file")
    segments = load_segments(elf)
    address, size = symbol_value(elf, b"selftest_seal")
    if size != SEAL_SIZE:
        fail(f"{path}: the seal has {size} bytes, not {SEAL_SIZE}")

    regions, seal_offset = [], None
    for physical, virtual, offset, length in segments:
        if virtual <= address < virtual + length:
            before = address - virtual
            seal_offset = offset + before
            regions.append((physical, offset, before))
            after = before + SEAL_SIZE
            regions.append((physical + after, offset + after, length - after))
        else:
            regions.append((physical, offset, length))
    regions = [region for region in regions if region[2] > 0]
    if seal_offset is None or len(regions) > REGIONS:
        fail(f"{path}: {len(regions)} regions to check, at most {REGIONS} fit")

    crc = 0
    for _, offset, length in regions:
        crc = zlib.crc32(elf[offset:offset + length], crc)
    words = [MAGIC, crc]
    for start, _, length in regions:
        words += [start, length]
    words += [0] * (2 + 2 * REGIONS - len(words))
    struct.pack_into(f"<{len(words)}I", elf, seal_offset, *words)
    path.write_bytes(elf)


if len(sys.argv) != 2:
    fail("usage: seal_image.py IMAGE.elf")
seal(pathlib.Path(sys.argv[1]))

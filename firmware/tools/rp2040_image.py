#!/usr/bin/env python3
"""rp2040_image.py crc IMAGE.elf: writes the CRC of the second stage behind it, which the RP2040's boot ROM checks.
rp2040_image.py uf2 IMAGE.elf: writes IMAGE.uf2, blocks of 256 bytes of flash, which the board takes as a USB drive.
"""

import pathlib
import struct
import sys

PT_LOAD = 1
FLASH, STAGE, PAGE = 0x10000000, 256, 256
FAMILY = 0xE48BFF56
UF2_START, UF2_END, UF2_HAS_FAMILY = (0x0A324655, 0x9E5D5157), 0x0AB16F30, 0x2000


def fail(message):
    sys.exit(f"rp2040_image.py: {message}")


def segments(elf):
    """(load address, file offset, size) of each loaded segment."""
    table, entry_size, count = struct.unpack_from("<I10xHH", elf, 28)
    for i in range(count):
        kind, offset, _, physical, size = struct.unpack_from("<5I", elf, table + i * entry_size)
        if kind == PT_LOAD and size > 0:
            yield physical, offset, size


def crc32(content):
    """Polynomial 0x04c11db7, from ones, neither reflected nor inverted."""
    crc = 0xFFFFFFFF
    for byte in content:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ (0x04C11DB7 if crc >> 31 else 0)) & 0xFFFFFFFF
    return crc


def write_crc(path):
    elf = bytearray(path.read_bytes())
    stage = [offset for address, offset, size in segments(elf) if address == FLASH and size >= STAGE]
    if not stage:
        fail(f"{path}: no second stage of {STAGE} bytes at {FLASH:#x}")
    at = stage[0]
    struct.pack_into("<I", elf, at + STAGE - 4, crc32(elf[at:at + STAGE - 4]))
    path.write_bytes(elf)


def write_uf2(path):
    elf = path.read_bytes()
    flash = {}
    for address, offset, size in segments(elf):
        for i in range(size):
            page = (address + i) // PAGE * PAGE
            flash.setdefault(page, bytearray(b"\xff" * PAGE))[address + i - page] = elf[offset + i]
    blocks = []
    for number, page in enumerate(sorted(flash)):
        head = struct.pack("<8I", *UF2_START, UF2_HAS_FAMILY, page, PAGE, number, len(flash), FAMILY)
        blocks.append(head + bytes(flash[page]).ljust(476, b"\0") + struct.pack("<I", UF2_END))
    path.with_suffix(".uf2").write_bytes(b"".join(blocks))


if len(sys.argv) != 3 or sys.argv[1] not in ("crc", "uf2"):
    fail("usage: rp2040_image.py crc | uf2 IMAGE.elf")
{"crc": write_crc, "uf2": write_uf2}[sys.argv[1]](pathlib.Path(sys.argv[2]))

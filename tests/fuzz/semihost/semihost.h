// Stands for picolibc's: what the drive of the emulated port reads is the input of a fuzz target.

#ifndef TESTS_FUZZ_SEMIHOST_H
#define TESTS_FUZZ_SEMIHOST_H

#include <stddef.h>
#include <stdint.h>

#define SH_OPEN_R_B 1
#define SH_OPEN_W_B 5

int       sys_semihost_open(const char *path, int mode);
uintptr_t sys_semihost_read(int file, void *buffer, size_t size); ///< returns what is missing
uintptr_t sys_semihost_write(int file, const void *buffer, size_t size);
int       sys_semihost_putc(char byte, void *file);

#endif

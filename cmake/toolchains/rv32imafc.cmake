# RISC-V, 32 bits, FPU of single precision.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR rv32imafc)
set(CMAKE_C_COMPILER riscv64-unknown-elf-gcc)
set(CMAKE_C_FLAGS_INIT "-march=rv32imafc -mabi=ilp32f")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# Cortex-M0: ARMv6-M, no division, no long multiplication, no FPU.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m0)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_C_FLAGS_INIT "-mthumb -mcpu=cortex-m0")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

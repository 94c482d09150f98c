# Programs for a QEMU machine, for trees that are configured with a file of cmake/toolchains: picolibc over semihosting,
# so that the tests read files and print as on the host, and tests/target/emulate to run them.
set(processor ${CMAKE_SYSTEM_PROCESSOR})
if(processor STREQUAL "cortex-m0") # microbit
  set(memory 0x0 0x40000 0x20000000 0x4000 0x1800)
  if(CMAKE_CURRENT_SOURCE_DIR STREQUAL "${PROJECT_SOURCE_DIR}/tests") # in the RAM that tests/target/emulate gives it
    set(memory 0x0 0x40000 0x20000000 0x400000 0x10000)
  endif()
elseif(processor STREQUAL "cortex-m33") # mps2-an505
  set(memory 0x10000000 0x400000 0x38000000 0x200000 0x10000)
elseif(processor MATCHES "^cortex-m") # mps2-an385, -an386, -an500
  set(memory 0x0 0x400000 0x20000000 0x400000 0x10000)
elseif(processor MATCHES "^rv32") # virt
  set(memory 0x80000000 0x200000 0x80200000 0x400000 0x10000)
else()
  message(FATAL_ERROR "No emulated machine for ${processor}: configure with a file of cmake/toolchains, "
                      "or with -DBUILD_TESTING=OFF")
endif()

add_compile_options(--specs=picolibc.specs)
add_link_options(--specs=picolibc.specs --oslib=semihost --crt0=semihost)
foreach(symbol __flash __flash_size __ram __ram_size __stack_size)
  list(POP_FRONT memory value)
  add_link_options(LINKER:--defsym=${symbol}=${value})
endforeach()
set(CMAKE_CROSSCOMPILING_EMULATOR ${PROJECT_SOURCE_DIR}/tests/target/emulate ${processor})

# Runs the linters as tests, with the versions that tools/setup installs: one test of clang-tidy and one of cppcheck per file, and one test
# of clang-format. They read compile_commands.json; nothing needs to be compiled.
find_program(TRIBO_CLANG_TIDY clang-tidy-19 REQUIRED)
find_program(TRIBO_CLANG_FORMAT clang-format-19 REQUIRED)
find_program(TRIBO_CPPCHECK cppcheck REQUIRED)

file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} lib/*.[ch] common/*.[ch] firmware/*.[ch] host_sim/*.[ch] python/*.[ch] tests/*.[ch]
     examples/*.[ch] wire/*.h tools/fmu/*.[ch] tools/identify/*.[ch] tools/link/*.[ch] tools/sim/*.[ch] playground/*.[ch])

# The interface of a libgpiod that is not installed; see tests/linux_vm.
set(no_gpiod "lines_v[12]")
if(TARGET tribo-drive-v2)
  set(no_gpiod "none")
elseif(TARGET tribo-drive)
  math(EXPR other "3 - ${TRIBO_GPIOD_VERSION}")
  set(no_gpiod "lines_v${other}")
endif()

foreach(source ${sources})
  # Skips sources that no target of this tree compiles, because there are no flags to check them with: python, tests/support/doors.c, tests/package,
  # tests/rig, the strange rigs of tests/identify, FMUs, and sources only for microcontrollers or WebAssembly.
  if(source MATCHES "[.]c$" AND NOT source MATCHES "^(examples/|python/|tools/(identify/|fmu/(axis|door|fmi[23]|joint|loop_q31|model|state))|tests/(support/doors|package/|rig/|identify/strange|target/(image|peers)|fuzz/fuzz_link|linux_vm/mock_pwm)|firmware/(app/seal|port/(emulated|rp2040|stm32f405|linux/${no_gpiod})))")
    add_test(NAME ${TRIBO_TEST_PREFIX}tidy/${source}
             COMMAND ${TRIBO_CLANG_TIDY} --quiet --warnings-as-errors=* -p ${PROJECT_BINARY_DIR} ${source}
             WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  endif()
  # cppcheck infers no flags from other sources as clang-tidy does, and forgets inline suppressions in a header of a source's second target.
  if(source MATCHES "^(firmware/app/seal|firmware/port/emulated/link|tests/fuzz/fuzz_link)[.]c$"
     OR (TEST ${TRIBO_TEST_PREFIX}tidy/${source} AND NOT source MATCHES "^(firmware/port/serial/link|tests/firmware/drive_cost)[.]c$"))
    add_test(NAME ${TRIBO_TEST_PREFIX}cppcheck/${source}
             COMMAND ${TRIBO_CPPCHECK} --quiet --project=${PROJECT_BINARY_DIR}/compile_commands.json --file-filter=${PROJECT_SOURCE_DIR}/${source}
                     --enable=warning,performance,portability --inline-suppr --suppress=normalCheckLevelMaxBranches
                     --suppress=shiftTooManyBitsSigned:*/lib/include/tribo/q31.h --error-exitcode=1)
  endif()
endforeach()

add_test(
  NAME ${TRIBO_TEST_PREFIX}format
  COMMAND ${TRIBO_CLANG_FORMAT} --dry-run --Werror ${sources}
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
add_custom_target(
  format
  COMMAND ${TRIBO_CLANG_FORMAT} -i ${sources}
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
  VERBATIM)

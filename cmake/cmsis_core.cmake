# CMSIS-Core (Arm, Apache-2.0), the names of a Cortex-M's own registers; its source is not part of this project. The first of:
#
#   1. -DTRIBO_CMSIS_CORE_DIR=... : the directory of core_cm4.h, of an installed CMSIS
#   2. the one in the user's cache
#   3. the npm package, fetched into that cache by npm from the registry that npm is configured for
#
# `cmake -P cmake/cmsis_core.cmake`, of tools/setup, only fetches.

set(cmsis_version 5.4.0-6)
set(cmsis_sha512 a2a1948d685098e3e549ccb03bb549e1a1ee2d0c2bcf18df9fee231e20e22424a6ed788a49cf3ff1c9081ebced234343fc875bf895c69c69d9fa23f3fe4f0505)

if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(TRIBO_CMSIS_CORE_DIR "" CACHE PATH "Directory of CMSIS-Core's core_cm4.h; empty: look for it")
endif()

include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")
set(cmsis_cache "${user_cache}/cmsis-core-${cmsis_version}")

function(fetch_cmsis_core)
  set(work "${cmsis_cache}.new")
  set(way_out "connect to the network and run tools/setup board, or give -DTRIBO_CMSIS_CORE_DIR=... (the directory of core_cm4.h)")
  find_program(TRIBO_NPM npm NO_CACHE)
  if(NOT TRIBO_NPM)
    message(FATAL_ERROR "CMSIS-Core is missing and there is no npm to fetch it: ${way_out}")
  endif()
  message(STATUS "Fetching CMSIS-Core ${cmsis_version} into ${cmsis_cache}")
  file(REMOVE_RECURSE "${work}")
  file(MAKE_DIRECTORY "${work}")
  execute_process(
    COMMAND "${TRIBO_NPM}" pack --loglevel=error --fetch-retries=1 --fetch-retry-mintimeout=1000
            "@xpack-3rd-party/arm-cmsis-core@${cmsis_version}"
    WORKING_DIRECTORY "${work}"
    TIMEOUT 120
    OUTPUT_QUIET # its reasons go to standard error
    RESULT_VARIABLE result)
  file(GLOB archive "${work}/*.tgz")
  if(NOT result EQUAL 0 OR NOT archive)
    file(REMOVE_RECURSE "${work}")
    message(FATAL_ERROR "CMSIS-Core is missing and npm cannot fetch it: ${way_out}")
  endif()
  file(SHA512 "${archive}" sha512)
  if(NOT sha512 STREQUAL cmsis_sha512)
    file(REMOVE_RECURSE "${work}")
    message(FATAL_ERROR "CMSIS-Core ${cmsis_version} from npm is not the expected one: give -DTRIBO_CMSIS_CORE_DIR=...")
  endif()
  file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${work}" PATTERNS package/LICENSE.txt package/CMSIS/Core/Include)
  file(RENAME "${work}/package" "${cmsis_cache}")
  file(REMOVE_RECURSE "${work}")
endfunction()

if(TRIBO_CMSIS_CORE_DIR)
  if(NOT EXISTS "${TRIBO_CMSIS_CORE_DIR}/core_cm4.h")
    message(FATAL_ERROR "TRIBO_CMSIS_CORE_DIR: no core_cm4.h in ${TRIBO_CMSIS_CORE_DIR}")
  endif()
  set(cmsis_dir "${TRIBO_CMSIS_CORE_DIR}")
else()
  set(cmsis_dir "${cmsis_cache}/CMSIS/Core/Include")
  if(NOT EXISTS "${cmsis_dir}/core_cm4.h")
    fetch_cmsis_core()
  endif()
endif()

if(NOT CMAKE_SCRIPT_MODE_FILE)
  message(STATUS "CMSIS-Core: ${cmsis_dir}")
  add_library(cmsis_core INTERFACE)
  target_include_directories(cmsis_core SYSTEM INTERFACE "${cmsis_dir}")
endif()

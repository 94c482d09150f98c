# Finds CMSIS-Core (Arm, Apache-2.0), which names a Cortex-M's own registers; its source is not part of this project. Takes the first of:
#
#   1. -DTRIBO_CMSIS_CORE_DIR=... : the directory of core_cm4.h in an installed CMSIS
#   2. the one in the user's cache
#   3. the npm package, which npm fetches into that cache from its configured registry
#
# tools/setup runs `cmake -P cmake/cmsis_core.cmake`, which only fetches it.

set(cmsis_version 5.4.0-6)
set(cmsis_sha512 a2a1948d685098e3e549ccb03bb549e1a1ee2d0c2bcf18df9fee231e20e22424a6ed788a49cf3ff1c9081ebced234343fc875bf895c69c69d9fa23f3fe4f0505)

if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(TRIBO_CMSIS_CORE_DIR "" CACHE PATH "Directory of CMSIS-Core's core_cm4.h; empty: look for it")
endif()

include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/npm.cmake")
set(cmsis_cache "${user_cache}/cmsis-core-${cmsis_version}")

if(TRIBO_CMSIS_CORE_DIR)
  if(NOT EXISTS "${TRIBO_CMSIS_CORE_DIR}/core_cm4.h")
    message(FATAL_ERROR "TRIBO_CMSIS_CORE_DIR: no core_cm4.h in ${TRIBO_CMSIS_CORE_DIR}")
  endif()
  set(cmsis_dir "${TRIBO_CMSIS_CORE_DIR}")
else()
  set(cmsis_dir "${cmsis_cache}/CMSIS/Core/Include")
  if(NOT EXISTS "${cmsis_dir}/core_cm4.h")
    fetch_npm_package(
      "@xpack-3rd-party/arm-cmsis-core" ${cmsis_version} ${cmsis_sha512} "${cmsis_cache}"
      "connect to the network and run tools/setup board, or give -DTRIBO_CMSIS_CORE_DIR=... (the directory of core_cm4.h)"
      package/LICENSE.txt package/CMSIS/Core/Include)
  endif()
endif()

if(NOT CMAKE_SCRIPT_MODE_FILE)
  message(STATUS "CMSIS-Core: ${cmsis_dir}")
  add_library(cmsis_core INTERFACE)
  target_include_directories(cmsis_core SYSTEM INTERFACE "${cmsis_dir}")
endif()

# Finds Unity (ThrowTheSwitch), the test framework; its source is not part of this project. Takes the first of:
#
#   1. -DTRIBO_UNITY_DIR=... : the directory of unity.c
#   2. an installed one: the Debian 13 package cmock contains it
#   3. the one that tools/setup extracted from that package on a system without it (Debian 12)
#   4. the release archive

set(TRIBO_UNITY_DIR "" CACHE PATH "Directory of Unity's unity.c and unity.h; empty: look for it")

include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")

if(TRIBO_UNITY_DIR)
  if(NOT EXISTS "${TRIBO_UNITY_DIR}/unity.c")
    message(FATAL_ERROR "TRIBO_UNITY_DIR: no unity.c in ${TRIBO_UNITY_DIR}")
  endif()
  set(unity_dir "${TRIBO_UNITY_DIR}")
else()
  set(archive_dir "${CMAKE_BINARY_DIR}/Unity-2.6.1/src")
  unset(unity_dir)
  foreach(dir /usr/share/cmock/vendor/unity/src /usr/share/cmock/vendor/unity "${user_cache}/unity"
              "${archive_dir}")
    if(EXISTS "${dir}/unity.c")
      set(unity_dir "${dir}")
      break()
    endif()
  endforeach()
  if(NOT unity_dir)
    set(archive "${CMAKE_BINARY_DIR}/unity.tar.gz")
    file(
      DOWNLOAD https://github.com/ThrowTheSwitch/Unity/archive/refs/tags/v2.6.1.tar.gz "${archive}"
      TIMEOUT 30
      STATUS status)
    list(GET status 0 code)
    if(code EQUAL 0)
      file(SHA256 "${archive}" sha256)
    endif()
    if(NOT code EQUAL 0 OR NOT sha256 STREQUAL "b41a66d45a6b99758fb3202ace6178177014d52fc524bf1f72687d93e9867292")
      file(REMOVE "${archive}")
      message(FATAL_ERROR "Unity not found and its archive cannot be downloaded: run tools/setup check, "
                          "or give -DTRIBO_UNITY_DIR=..., or leave the tests out with -DBUILD_TESTING=OFF")
    endif()
    file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${CMAKE_BINARY_DIR}")
    set(unity_dir "${archive_dir}")
  endif()
endif()
message(STATUS "Unity: ${unity_dir}")

add_library(unity STATIC EXCLUDE_FROM_ALL "${unity_dir}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${unity_dir}")
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)

# Finds rp2040js (Uri Shaked, MIT), the emulator in which tests/boards/test_rp2040.py runs the RP2040's image; it is not part of this project.
# tools/setup rp2040 runs `cmake -P cmake/rp2040js.cmake`, which fetches it into the user's cache. Included, this file only sets its path.

set(rp2040js_version 1.4.1)
set(rp2040js_sha512 633af9c46ed9c1bb40e74218014d64fe84a84b20c084fb53e6a0bf436785029a0bb80604f0341b3c830fb3fd2487821eb5de0fd0ea4a93708891f36a8dcaf9ea)

include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")
set(rp2040js_cache "${user_cache}/rp2040js-${rp2040js_version}")
if(CMAKE_SCRIPT_MODE_FILE AND NOT EXISTS "${rp2040js_cache}/dist/esm/index.js")
  include("${CMAKE_CURRENT_LIST_DIR}/npm.cmake")
  fetch_npm_package(
    rp2040js ${rp2040js_version} ${rp2040js_sha512} "${rp2040js_cache}" "connect to the network and run tools/setup rp2040"
    package/LICENSE package/package.json package/dist/esm)
endif()

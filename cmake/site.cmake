# Builds the documentation as a site: `cmake --build --preset host-release --target site`, then open build/host-release/site/site/index.html.
# mkdocs-material generates it. Its search needs iframe-worker (Martin Donath, MIT) if a page is opened as a file. Neither is part of this project:
# tools/setup site installs them, iframe-worker by `cmake -P cmake/site.cmake`.

set(iframe_worker_version 1.0.4)
set(iframe_worker_sha512
    ae879a688f8b8352c935f8290a3a117bff96cc48f2f7e674f0ba04beef393023db063c26faa5f3f00839534e651dae95d42cac6721b313448e900b52500e6aed)
include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")
set(iframe_worker_cache "${user_cache}/iframe-worker-${iframe_worker_version}")
if(CMAKE_SCRIPT_MODE_FILE)
  if(NOT EXISTS "${iframe_worker_cache}")
    include("${CMAKE_CURRENT_LIST_DIR}/npm.cmake")
    fetch_npm_package(
      iframe-worker ${iframe_worker_version} ${iframe_worker_sha512} "${iframe_worker_cache}" "connect to the network and run tools/setup site"
      package/LICENSE package/shim/index.js)
  endif()
  return()
endif()

set(TRIBO_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with the packages that tools/setup brings")
if(TARGET tribo-sim AND TARGET tribo-link AND TARGET tribo-drive)
  file(SHA256 ${PROJECT_SOURCE_DIR}/tests/site/requirements.txt packages)
  set(build_site
      ${CMAKE_COMMAND} -E env PYTHONPATH=${user_cache}/site-python-${packages} ${TRIBO_PYTHON} -B ${PROJECT_SOURCE_DIR}/docs/site/build.py --shim
      ${iframe_worker_cache}/shim/index.js --sim $<TARGET_FILE:tribo-sim> --link $<TARGET_FILE:tribo-link> --drive $<TARGET_FILE:tribo-drive>)
  add_custom_target(
    site
    COMMAND ${build_site} ${PROJECT_BINARY_DIR}/site
    DEPENDS tribo-sim tribo-link tribo-drive
    VERBATIM)
  if(TRIBO_PACKAGE_TESTS)
    add_test(NAME ${TRIBO_TEST_PREFIX}site COMMAND ${build_site} ${PROJECT_BINARY_DIR}/tests/site)
    set_tests_properties(${TRIBO_TEST_PREFIX}site PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 1500)
  endif()
endif()

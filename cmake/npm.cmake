# Fetches npm packages that are not part of this project from npm's configured registry into the user's cache. Only the requested parts
# are kept.

# fetch_npm_package(NAME VERSION SHA512 FOLDER WAY_OUT PATTERN...): FOLDER receives the package's files, the patterns select files of
# package/..., and WAY_OUT says what the user can do without npm or a network.
function(fetch_npm_package name version sha512 folder way_out)
  set(work "${folder}.new")
  find_program(TRIBO_NPM npm NO_CACHE)
  if(NOT TRIBO_NPM)
    message(FATAL_ERROR "${name} is missing and there is no npm to fetch it: ${way_out}")
  endif()
  message(STATUS "Fetching ${name} ${version} into ${folder}")
  file(REMOVE_RECURSE "${work}")
  file(MAKE_DIRECTORY "${work}")
  execute_process(
    COMMAND "${TRIBO_NPM}" pack --loglevel=error --fetch-retries=1 --fetch-retry-mintimeout=1000 "${name}@${version}"
    WORKING_DIRECTORY "${work}"
    TIMEOUT 120
    OUTPUT_QUIET # npm prints its reasons to standard error
    RESULT_VARIABLE result)
  file(GLOB archive "${work}/*.tgz")
  if(NOT result EQUAL 0 OR NOT archive)
    file(REMOVE_RECURSE "${work}")
    message(FATAL_ERROR "${name} is missing and npm cannot fetch it: ${way_out}")
  endif()
  file(SHA512 "${archive}" found)
  if(NOT found STREQUAL sha512)
    file(REMOVE_RECURSE "${work}")
    message(FATAL_ERROR "${name} ${version} from npm is not the expected one: ${way_out}")
  endif()
  file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${work}" PATTERNS ${ARGN})
  file(REMOVE_RECURSE "${folder}")
  file(RENAME "${work}/package" "${folder}")
  file(REMOVE_RECURSE "${work}")
endfunction()

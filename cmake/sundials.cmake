# SUNDIALS CVODE with serial vectors and dense matrices: target sundials_cvode_serial. Its own CMake package is not used, as
# Debian's asks for OpenMP of the compiler, for parts that nothing here needs.
find_path(SUNDIALS_INCLUDE_DIR cvode/cvode.h)
mark_as_advanced(SUNDIALS_INCLUDE_DIR)
set(sundials_libraries "")
foreach(library cvode nvecserial sunmatrixdense sunlinsoldense sunnonlinsolfixedpoint)
  find_library(SUNDIALS_${library}_LIBRARY sundials_${library})
  mark_as_advanced(SUNDIALS_${library}_LIBRARY)
  list(APPEND sundials_libraries ${SUNDIALS_${library}_LIBRARY})
endforeach()
if("${SUNDIALS_INCLUDE_DIR};${sundials_libraries}" MATCHES "NOTFOUND")
  message(FATAL_ERROR "SUNDIALS (CVODE) not found, which the tests compare the truth models with: "
                      "run tools/setup check, or leave the tests out with -DBUILD_TESTING=OFF")
endif()
# From version 7 on.
find_library(SUNDIALS_core_LIBRARY sundials_core)
mark_as_advanced(SUNDIALS_core_LIBRARY)
if(SUNDIALS_core_LIBRARY)
  list(APPEND sundials_libraries ${SUNDIALS_core_LIBRARY})
endif()
add_library(sundials_cvode_serial INTERFACE)
target_include_directories(sundials_cvode_serial SYSTEM INTERFACE ${SUNDIALS_INCLUDE_DIR})
target_link_libraries(sundials_cvode_serial INTERFACE ${sundials_libraries})

# tribo_add_man(TARGET SUMMARY [MORE]): builds and installs TARGET's manual page from the help of its parsers, if TARGET can be run here.
# MORE is a roff file, which follows the options.
# tribo_add_man_of_python(NAME SUMMARY FOLDER WORDS...): does this for a Python program with files in FOLDER, which WORDS start.
#
# All pages are in man/man1 of the build; a wheel installs this folder unchanged (python/CMakeLists.txt).

find_package(Python3 COMPONENTS Interpreter)

# Makes the page of the program NAME, which COMMAND runs, and makes it again when DEPENDS change.
function(tribo_add_page name summary more)
  cmake_parse_arguments(arg "" "" "COMMAND;DEPENDS" ${ARGN})
  set(make ${PROJECT_SOURCE_DIR}/cmake/man.py)
  set(pages ${PROJECT_BINARY_DIR}/man/man1)
  file(MAKE_DIRECTORY ${pages})
  add_custom_command(
    OUTPUT ${pages}/${name}.1
    COMMAND ${Python3_EXECUTABLE} -B ${make} ${name} ${summary} "${more}" ${arg_COMMAND} > ${pages}/${name}.1
    DEPENDS ${make} ${more} ${arg_DEPENDS}
    VERBATIM)
  add_custom_target(${name}-man ALL DEPENDS ${pages}/${name}.1)
  install(FILES ${pages}/${name}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endfunction()

function(tribo_add_man_of_python name summary folder)
  if(NOT Python3_FOUND)
    return()
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.py)
  set(tools ${PROJECT_SOURCE_DIR}/tools)
  tribo_add_page(
    ${name} "${summary}" ""
    COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${tools}:${tools}/design:${tools}/identify:${tools}/rig ${Python3_EXECUTABLE} -B ${ARGN}
    DEPENDS ${sources})
endfunction()

function(tribo_add_man target summary)
  if((CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR) OR NOT Python3_FOUND)
    add_custom_target(${target}-man) # makes no page
    return()
  endif()
  tribo_add_page(${target} "${summary}" "${ARGV2}" COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${target}> DEPENDS ${target})
endfunction()

# tribo_add_man(TARGET SUMMARY): builds and installs TARGET's manual page, made of its parsers' help; not where it cannot be run.

find_package(Python3 COMPONENTS Interpreter)

function(tribo_add_man target summary)
  if((CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR) OR NOT Python3_FOUND)
    return()
  endif()
  set(page ${CMAKE_CURRENT_BINARY_DIR}/${target}.1)
  set(make ${PROJECT_SOURCE_DIR}/cmake/man.py)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${Python3_EXECUTABLE} -B ${make} ${summary} ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${target}> > ${page}
    DEPENDS ${target} ${make}
    VERBATIM)
  add_custom_target(${target}-man ALL DEPENDS ${page})
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endfunction()

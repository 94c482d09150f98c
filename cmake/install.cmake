# Installs tribo::lib for find_package(tribo), and tribo.pc for pkg-config. Both use relative paths, so the installed tree may be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS tribo EXPORT tribo-config ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY lib/include/tribo TYPE INCLUDE)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tribo)
install(EXPORT tribo-config NAMESPACE tribo:: DESTINATION ${config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tribo-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tribo-config-version.cmake DESTINATION ${config_dir})

file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/tribo.pc.in tribo.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/tribo.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT drive)

# Installs the tools that need no Python package except matplotlib, with their names in bin. pip installs tribo-design, tribo-identify and
# tribo-rig (docs/python.md).
if(TRIBO_HOST_SIM)
  include(cmake/uplot.cmake)
  set(tools ${CMAKE_INSTALL_DATADIR}/tribo/tools)
  install(PROGRAMS tools/tribo-plot tools/link/demo-drive DESTINATION ${tools})
  install(DIRECTORY tools/tribo_plot DESTINATION ${tools} PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY ${uplot_cache}/ DESTINATION ${tools}/tribo_plot/uplot OPTIONAL) # fetched by tools/setup plot
  install(FILES tools/link/plotjuggler.xml DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT drive)
  set(tools_in_bin tribo-plot demo-drive)
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64") # tools/fmu installs it
    list(APPEND tools_in_bin tribo-fmu)
  endif()
  file(RELATIVE_PATH tools_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/tribo/tools)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  foreach(tool ${tools_in_bin})
    string(REGEX REPLACE "^tribo-" "" name ${tool})
    file(CREATE_LINK ${tools_from_bin}/${tool} ${PROJECT_BINARY_DIR}/bin/tribo-${name} SYMBOLIC)
    install(FILES ${PROJECT_BINARY_DIR}/bin/tribo-${name} DESTINATION ${CMAKE_INSTALL_BINDIR})
  endforeach()
  include(cmake/man.cmake)
  set(tools ${PROJECT_SOURCE_DIR}/tools)
  tribo_add_man_of_python(tribo-plot "pictures of runs, replays, sweeps, traces and logs of a drive" ${tools}/tribo_plot -m tribo_plot)
  tribo_add_man_of_python(tribo-demo-drive "a live drive to play with, simulated" ${tools}/tribo_plot ${tools}/link/demo-drive)
  if("tribo-fmu" IN_LIST tools_in_bin)
    tribo_add_man_of_python(tribo-fmu "FMUs of a scenario's force loop, compensator or plant" ${tools}/tribo_plot ${tools}/tribo-fmu)
  endif()
endif()

# tribo::lib for find_package(tribo), and tribo.pc for pkg-config. Both find themselves: the installed tree may move.
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

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The tools that need no Python package but matplotlib, and in bin by their names. tribo-design, tribo-identify and tribo-rig are
# installed by pip (docs/python.md).
if(TRIBO_HOST_SIM)
  include(cmake/uplot.cmake)
  set(tools ${CMAKE_INSTALL_DATADIR}/tribo/tools)
  install(PROGRAMS tools/tribo-plot tools/sweep-report tools/demo-drive DESTINATION ${tools})
  install(DIRECTORY tools/tribo_plot DESTINATION ${tools} PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY ${uplot_cache}/ DESTINATION ${tools}/uplot OPTIONAL) # fetched by tools/setup plot
  install(FILES tools/link/plotjuggler.xml DESTINATION ${CMAKE_INSTALL_DOCDIR})
  file(RELATIVE_PATH tools_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/tribo/tools)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  foreach(tool tribo-plot sweep-report demo-drive)
    string(REGEX REPLACE "^tribo-" "" name ${tool})
    file(CREATE_LINK ${tools_from_bin}/${tool} ${PROJECT_BINARY_DIR}/bin/tribo-${name} SYMBOLIC)
    install(FILES ${PROJECT_BINARY_DIR}/bin/tribo-${name} DESTINATION ${CMAKE_INSTALL_BINDIR})
  endforeach()
endif()

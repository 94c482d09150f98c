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

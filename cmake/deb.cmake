# Describes a Debian package for CPack; tools/dev/deb builds it and sets its dependencies.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tribo)
set(CPACK_PACKAGE_VENDOR "The tribo authors")
set(CPACK_PACKAGE_CONTACT "The tribo authors <tribo@localhost>") # the format requires an address
set(CPACK_SET_DESTDIR ON)                                         # the systemd unit contains the prefix
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-matplotlib")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "cmake, ninja-build, gcc") # for tribo-fmu
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "Takes the friction out of motor drives
The library for a drive's firmware, its simulator, the drive on a Linux board
and the tools to talk to one.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/deb/postinst)
include(CPack)

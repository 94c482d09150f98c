# Every target of this project links tribo_warnings privately, so it never reaches a user's build.
# The presets turn warnings into errors (CMAKE_COMPILE_WARNING_AS_ERROR).
add_library(tribo_warnings INTERFACE)
target_compile_options(
  tribo_warnings
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Wconversion
            -Wsign-conversion
            -Wshadow
            -Wdouble-promotion
            -Wstrict-prototypes
            -Wmissing-prototypes
            -Wundef)

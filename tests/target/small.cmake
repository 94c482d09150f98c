# The library at -Os, by function, as a drive short of flash would build it: tribo_small.
get_target_property(sources tribo SOURCES)
list(TRANSFORM sources PREPEND ${PROJECT_SOURCE_DIR}/lib/)
add_library(tribo_small STATIC ${sources})
target_include_directories(tribo_small PUBLIC ${PROJECT_SOURCE_DIR}/lib/include)
target_compile_options(tribo_small PRIVATE -ffreestanding -ffp-contract=off -Os -ffunction-sections -fdata-sections)
target_link_libraries(tribo_small PRIVATE tribo_warnings)

# Finds uPlot (Leon Sorokin, MIT), which lets the HTML pages of tools/tribo-plot zoom; it is not part of this project. tools/setup plot runs
# `cmake -P cmake/uplot.cmake`, which fetches it into the user's cache. Included, this file only sets its path; tribo-plot reports if it is missing.

file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/../tools/tribo_plot/page.py" uplot_version REGEX "^UPLOT_VERSION")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" uplot_version "${uplot_version}")
set(uplot_sha512 2883159c6ebccefbb95d751b0b82d010f9e1c0ec41b8bc96d401eda66e882935c89a46cb824332fa369b8cb8122cc6ac36e186cd09bf7a9ded3a4c93c6989023)

include("${CMAKE_CURRENT_LIST_DIR}/user_cache.cmake")
set(uplot_cache "${user_cache}/uplot-${uplot_version}")
if(CMAKE_SCRIPT_MODE_FILE AND NOT EXISTS "${uplot_cache}/dist/uPlot.iife.min.js")
  include("${CMAKE_CURRENT_LIST_DIR}/npm.cmake")
  fetch_npm_package(
    uplot ${uplot_version} ${uplot_sha512} "${uplot_cache}" "connect to the network and run tools/setup plot"
    package/LICENSE package/dist/uPlot.iife.min.js package/dist/uPlot.min.css)
endif()

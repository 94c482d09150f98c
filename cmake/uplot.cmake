# uPlot (Leon Sorokin, MIT), which the HTML pages of tools/tribo-plot zoom with; no part of this project. `cmake -P cmake/uplot.cmake`,
# of tools/setup plot, fetches it into the user's cache. Included, it only says where that is: tribo-plot tells if it is missing.

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

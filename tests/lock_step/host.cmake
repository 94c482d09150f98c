# Brings the host's tribo-sim up to date in the tree of the preset host-release. One at a time: the trees of several
# targets may be tested at once.
set(root ${CMAKE_CURRENT_LIST_DIR}/../..)
set(way_out "lock-step tests need the host's tribo-sim: 'tools/setup check' installs what it needs, or give -DTRIBO_SIM=...")
file(MAKE_DIRECTORY ${root}/build)
file(LOCK ${root}/build/host-release.lock GUARD PROCESS)
if(NOT EXISTS ${root}/build/host-release/build.ninja)
  execute_process(COMMAND ${CMAKE_COMMAND} --preset host-release WORKING_DIRECTORY ${root} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${way_out}")
  endif()
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --build --preset host-release --target tribo-sim WORKING_DIRECTORY ${root}
                RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${way_out}")
endif()

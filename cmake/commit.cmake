# Writes OUTPUT, a header with the commit of SOURCE: cmake -D SOURCE=... -D OUTPUT=... -P commit.cmake. Leaves an unchanged header alone, so that
# nothing is compiled again. The commit is empty outside a checkout, for example in a released archive.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(EXISTS ${SOURCE}/.git)
  execute_process(
    COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
    OUTPUT_VARIABLE described
    OUTPUT_STRIP_TRAILING_WHITESPACE
    ERROR_QUIET
    RESULT_VARIABLE failed)
  if(failed EQUAL 0)
    set(commit " at ${described}")
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define SIM_AT_COMMIT \"@commit@\"\n" @ONLY)

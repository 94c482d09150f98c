# Sets the cache of the user, in which files fetched for this project are kept.

set(user_cache "$ENV{XDG_CACHE_HOME}")
if(user_cache STREQUAL "")
  set(user_cache "$ENV{HOME}/.cache")
endif()
string(APPEND user_cache /tribo)

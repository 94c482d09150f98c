# Where what is fetched for this project is kept, of each user.

set(user_cache "$ENV{XDG_CACHE_HOME}")
if(user_cache STREQUAL "")
  set(user_cache "$ENV{HOME}/.cache")
endif()
string(APPEND user_cache /tribo)

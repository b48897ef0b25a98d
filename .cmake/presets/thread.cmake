# Debug under the sanitizer of threads: bash tests/sanitize.sh thread
include(${CMAKE_CURRENT_LIST_DIR}/debug.cmake)
set(OBSCURA_SANITIZE thread CACHE STRING "Sanitizers for the whole build" FORCE)

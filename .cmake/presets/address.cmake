# Debug under the sanitizers of addresses, leaks and undefined behaviour: bash tests/sanitize.sh address
include(${CMAKE_CURRENT_LIST_DIR}/debug.cmake)
set(OBSCURA_SANITIZE address,undefined CACHE STRING "Sanitizers for the whole build" FORCE)

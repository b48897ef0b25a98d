# The tests with assertions, ours and the standard library's: cmake -C .cmake/presets/debug.cmake -S . -B build_debug -G Ninja
set(CMAKE_BUILD_TYPE Debug CACHE STRING "Build type" FORCE)
set(CMAKE_CXX_FLAGS_DEBUG "-O2 -g1 -D_GLIBCXX_ASSERTIONS" CACHE STRING "Flags of a debug build" FORCE)
set(OBSCURA_BUILD_TESTS ON CACHE BOOL "Build the tests" FORCE)

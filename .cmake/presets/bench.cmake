# Release with the benchmarks: cmake -C .cmake/presets/bench.cmake -S . -B build -G Ninja
include(${CMAKE_CURRENT_LIST_DIR}/release.cmake)
set(OBSCURA_BUILD_BENCH ON CACHE BOOL "Build the benchmarks" FORCE)

# Compiler settings that every target of this build shares.
# Those of a whole build are the top-level project's to choose: inside another project, what that project says holds.
if(PROJECT_IS_TOP_LEVEL)
  if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
  endif()
  set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})

  find_program(CCACHE_PROGRAM ccache)
  if(CCACHE_PROGRAM)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=1 ${CCACHE_PROGRAM})
  endif()
endif()
# Of this project's own targets alone: a variable ends with its folder.
set(CMAKE_CXX_EXTENSIONS OFF)

add_library(obscura_settings INTERFACE)
target_compile_features(obscura_settings INTERFACE cxx_std_20)
target_compile_options(obscura_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual -Wunused
  # The same bits on every machine: no contraction that one target has and another lacks.
  -ffp-contract=off)
if(OBSCURA_SANITIZE)
  # A finding of the undefined sanitizer ends the program too, so that no test passes over it.
  add_compile_options(-fsanitize=${OBSCURA_SANITIZE} -fno-sanitize-recover=all
    -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=${OBSCURA_SANITIZE})
endif()

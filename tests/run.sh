#!/usr/bin/env bash
# Installs what is missing, builds into build/ with the tests and runs them. Arguments go to ctest.
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
build_project release -DOBSCURA_BUILD_TESTS=ON
ctest --test-dir "$root/build" --output-on-failure -j "$(nproc)" "$@"

#!/usr/bin/env bash
# Builds the library and the tests of octree, photon and stability with assertions on, ours and the standard library's,
# into build_debug/, and runs them. Arguments go to ctest.
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
configure_project debug
cmake --build "$build" --target tests_octree tests_photon tests_stability
ctest --test-dir "$build" --output-on-failure -j "$(nproc)" -R '^(octree|photon|stability):' "$@"

#!/usr/bin/env bash
# Runs the tests of build/ with floating point exceptions trapped: the first ends its program, and the test's
# name is told. Programs may be named (octree photon ...); none: all of the library's.
#   bash tests/trap_fpe.sh [folder ...]
# Overflow and division by zero are trapped everywhere. Invalid is where Embree takes no part: it computes with
# NaN on purpose, on threads of its own. Left out: tests that feed NaN and infinity in on purpose
# ([not_finite]), and those of SIMD targets that Highway only imitates ([imitated]).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
[ $# -gt 0 ] || set -- octree photon sensor physics stability
for folder in "$@"; do
  program="$root/build/tests_$folder"
  echo "tests_$folder: overflow, divbyzero"
  OBSCURA_TRAP_FPE=overflow,divbyzero "$program" "~[not_finite]~[imitated]"
  echo "tests_$folder: invalid"
  OBSCURA_TRAP_FPE=invalid "$program" "~[not_finite]~[imitated]~[surfaces]"
done

#!/usr/bin/env bash
# Builds the tests with a sanitizer and assertions, into build_address/ or build_thread/, and runs them:
#   bash tests/sanitize.sh address|thread [arguments of ctest]
# The thread sanitizer must see into oneTBB to know what happens before what; the system's is not built
# for that: TBB_LIBRARY names the folder of a libtbb of the same version that is.
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
kind=${1:-}
case "$kind" in
  address | thread) shift ;;
  *) echo "usage: bash tests/sanitize.sh address|thread [arguments of ctest]" >&2; exit 2 ;;
esac

if [ "$kind" = thread ]; then
  [ -e "${TBB_LIBRARY:-}/libtbb.so" ] || { echo "TBB_LIBRARY: name a folder with a libtbb.so that is built with -fsanitize=thread" >&2; exit 2; }
  export LD_LIBRARY_PATH="$TBB_LIBRARY${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
fi

support="$root/tests/support"
export ASAN_OPTIONS="detect_stack_use_after_return=1:strict_string_checks=1${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
export LSAN_OPTIONS="suppressions=$support/lsan.supp:print_suppressions=0${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
export UBSAN_OPTIONS="print_stacktrace=1${UBSAN_OPTIONS:+:$UBSAN_OPTIONS}"
export TSAN_OPTIONS="suppressions=$support/tsan.supp:halt_on_error=1:second_deadlock_stack=1${TSAN_OPTIONS:+:$TSAN_OPTIONS}"

build_project "$kind"

# Left out: what compiles without the sanitizer, and files on which OpenVDB asks for as much memory as an
# unset length says, which ends a sanitized program where another gets bad_alloc.
ctest --test-dir "$build" --output-on-failure -j "$(nproc)" \
  -E "every public header compiles alone|an installed package serves|truncated files and wrong versions" "$@"

#!/usr/bin/env bash
# Builds tests/bench/effects_bench, counts its instructions with callgrind (installed where it is missing) and prints
# the table of photon/MEASURED.md, "What is off costs nothing". Arguments pick cases: bash tests/bench/effects.sh b2
source "$(dirname "${BASH_SOURCE[0]}")/../../.cmake/setup.sh"
configure_project bench
command -v valgrind > /dev/null || $([ "$(id -u)" -eq 0 ] || echo sudo) apt-get install -y -qq valgrind > /dev/null
cmake --build "$build" --target effects_bench > /dev/null

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
valgrind --tool=callgrind --instr-atstart=no --callgrind-out-file="$folder/part" \
  "$build/effects_bench" "$@" > "$folder/cases" 2> "$folder/log" || { cat "$folder/log" "$folder/cases" >&2; exit 1; }
echo "| scene | program | minimal loop | ratio |"
echo "|---|---|---|---|"
awk -F' [|] ' '
  FILENAME ~ /cases$/ { if ($3 + 0 > 0) per[$1] = $2; next }
  /^desc: Trigger: Client Request:/ { sub(/^desc: Trigger: Client Request: /, "", $1); name = $1; side = $2 }
  /^totals:/ { split($0, t, " "); count[name, side] = t[2]; if (side == "minimal") order[++n] = name }
  END {
    for (i = 1; i <= n; ++i) {
      c = order[i]
      printf "| %s | %.0f | %.0f | %.3f |\n", c, count[c, "program"] / per[c], count[c, "minimal"] / per[c], count[c, "program"] / count[c, "minimal"]
    }
  }' "$folder/cases" $(ls -v "$folder"/part.*)

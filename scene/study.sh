#!/usr/bin/env bash
# Measures what accuracy costs for the demo on this machine: the table in README.md, the plot beside the demo
# (scene/examples/accuracy.svg) and a page with everything (build/demo/study.html). Argument: the time to spend.
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
build_project release
mkdir -p "$root/build/demo"
table=$("$root/build/obscura" study "$root/scene/examples/smoke_at_night.json" -f -o "$root/build/demo/study.html" \
  --plot "$root/scene/examples/accuracy.svg" --budget "${1:-10min}" --markdown)
TABLE=$table awk '
  /^<!-- \/study -->$/ { inside = 0 }
  !inside { print }
  /^<!-- study -->$/ { inside = 1; print ENVIRON["TABLE"] }' "$root/README.md" > "$root/build/demo/README.md"
cat "$root/build/demo/README.md" > "$root/README.md"
echo "The table: README.md; the plot: scene/examples/accuracy.svg; pictures, plots and every run: build/demo/study.html"

#!/usr/bin/env bash
# Installs what is missing, builds into build/ and renders the demo into build/demo/: a smoke screen at
# night in 8-12 um, as numbers (smoke.exr, smoke.json) and as pictures (smoke.png).
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
build_project release
mkdir -p "$root/build/demo"
"$root/build/obscura" render "$root/scene/examples/smoke_at_night.json" -f \
  -o "$root/build/demo/smoke.exr" --preview "$root/build/demo/smoke.png"
echo "Radiance, transmission, apparent temperature and error: build/demo/smoke.exr"
echo "The same to look at: build/demo/smoke.png; what it took: build/demo/smoke.json"

#!/usr/bin/env bash
# Installs a build into a folder of its own and builds and runs a program that uses the installed package.
# Arguments: build folder, source folder of the consumer, folder to work in.
set -euo pipefail
build=$1 consumer=$2 work=$3
rm -rf "$work"
cmake --install "$build" --prefix "$work/prefix" > "$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake -S "$consumer" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >> "$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake --build "$work/build" >> "$work.log" 2>&1 || { cat "$work.log"; exit 1; }
"$work/build/consumer"

#!/usr/bin/env bash
# Configures a project that holds Obscura as a part and checks that neither changes the other's settings.
# Arguments: source folder of that project, folder to work in.
set -euo pipefail
source=$1 work=$2
rm -rf "$work"
env -u CXXFLAGS cmake -S "$source" -B "$work" -G Ninja > "$work.log" 2>&1 || { cat "$work.log"; exit 1; }

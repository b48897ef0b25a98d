#!/usr/bin/env bash
# Fails and names the places where a file is not as .clang-format says. To mend: bash tests/format.sh -i
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
git ls-files '*.h' '*.cpp' | xargs clang-format "${1:---dry-run}" --Werror

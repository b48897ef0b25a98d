# Sourced by scene/demo.sh and tests/run.sh: installs what is missing from Debian, then configures and
# builds. Arguments go to cmake.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

install_packages() {
  local wanted missing=()
  mapfile -t wanted < "$root/.cmake/packages.txt"
  for package in "${wanted[@]}"; do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  echo "Installing: ${missing[*]}"
  local sudo=""
  [ "$(id -u)" -eq 0 ] || sudo=sudo
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
}

build_project() {
  install_packages
  cmake -S "$root" -B "$root/build" -G Ninja "$@" > "$root/build.log" 2>&1 || { cat "$root/build.log"; rm -f "$root/build.log"; exit 1; }
  rm -f "$root/build.log"
  cmake --build "$root/build"
}

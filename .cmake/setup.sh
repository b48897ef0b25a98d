# Sourced by the scripts that build: installs what is missing from Debian, then configures by one of
# .cmake/presets and builds.
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

# Arguments: the preset, then what goes to cmake. Sets build, the preset's folder.
configure_project() {
  local preset=$1 log
  shift
  case "$preset" in
    release | bench) build="$root/build" ;;
    *) build="$root/build_$preset" ;;
  esac
  install_packages
  log=$(mktemp)
  cmake -C "$root/.cmake/presets/$preset.cmake" -S "$root" -B "$build" -G Ninja "$@" > "$log" 2>&1 || { cat "$log"; rm -f "$log"; exit 1; }
  rm -f "$log"
}

build_project() {
  configure_project "$@"
  cmake --build "$build"
}

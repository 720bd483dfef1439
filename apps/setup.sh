#!/usr/bin/env bash
# usage: bash apps/setup.sh [OPTION OF CMAKE ...]
# Makes a Debian 12 machine ready: installs what is missing of apps/packages.txt, then configures build/release.
# Needs root or sudo only where something is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
    echo "apps/setup.sh: $*" >&2
    exit 1
}

packages() { sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' apps/packages.txt; }

missing_packages() {
    local package
    for package in $(packages); do
        [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)" = installed ] || echo "$package"
    done
}

install_packages() {
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "packages are missing and there is no sudo; as root: apt-get install $*"
        as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300)
    echo "installing: $*"
    "${apt[@]}" update || echo "apps/setup.sh: apt-get update failed; going on with the lists there are" >&2
    "${apt[@]}" install --no-install-recommends "$@" </dev/null || fail "apt-get could not install: $*"
}

command -v dpkg-query >/dev/null || fail "is for Debian and its kin; elsewhere install what apps/packages.txt names, then: cmake --preset release"
missing=$(missing_packages)
# Word by word: one package each.
# shellcheck disable=SC2086
[ -z "$missing" ] || install_packages $missing

options=("$@")
if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake --preset release "${options[@]}" || fail "cmake could not configure build/release, see above"

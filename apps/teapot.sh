#!/usr/bin/env bash
# usage: bash apps/teapot.sh [OPTION OF gradus teapot ...]
# The paper's experiment from nothing: sets the machine up, builds, meshes the teapot without and with gradation, and leaves meshes,
# reports and pictures in build/teapot. Options given here come last, so they replace those below.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash apps/setup.sh
cmake --build build/release --target gradus_app --parallel "$(nproc)"
build/release/gradus teapot --alpha 0.3 --hmin 0.01 --hmax 0.5 --shock 1.5 --out build/teapot "$@"

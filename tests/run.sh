#!/usr/bin/env bash
# usage: bash tests/run.sh [OPTION OF CMAKE ...]
# Sets the machine up, builds everything, runs all tests and fuzzes for some seconds, e.g. `bash tests/run.sh -DGRADUS_WARNINGS_AS_ERRORS=ON`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash apps/setup.sh "$@"
cmake --build build/release --parallel "$(nproc)"
ctest --test-dir build/release --parallel "$(nproc)" --output-on-failure --no-tests=error

if command -v clang++ >/dev/null; then
    cmake --preset fuzz "$@"
    cmake --build build/fuzz --parallel "$(nproc)"
    ctest --test-dir build/fuzz --label-regex fuzz --parallel "$(nproc)" --output-on-failure --no-tests=error
else
    echo "tests/run.sh: no clang++, so no fuzzing (libFuzzer comes with it)" >&2
fi

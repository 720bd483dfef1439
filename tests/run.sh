#!/usr/bin/env bash
# usage: bash tests/run.sh [OPTION OF CMAKE ...]
# Sets the machine up, builds everything and runs all tests, e.g. `bash tests/run.sh -DGRADUS_WARNINGS_AS_ERRORS=ON`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash apps/setup.sh "$@"
cmake --build build/release --parallel "$(nproc)"
ctest --test-dir build/release --parallel "$(nproc)" --output-on-failure --no-tests=error

#!/usr/bin/env bash
# usage: bash tests/tidy.sh [FILE ...]
# Looks with clang-tidy for faults in sources of the library: those named, else those that the last commit changed, as all of them take a
# quarter of an hour. Needs the build in build/fuzz, which is clang's (tests/run.sh makes it). Exits with 1 if it finds some.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ ! -f build/fuzz/compile_commands.json ]; then
    echo "tests/tidy.sh: no build/fuzz, which tests/run.sh makes with clang++, so no look with clang-tidy" >&2
    exit 0
fi
if [ $# -gt 0 ]; then
    files=("$@")
else
    since=$(git rev-list --max-count=2 HEAD | tail -n 1)
    mapfile -t files < <(git diff --name-only --diff-filter=d "$since" -- 'src/*.cpp')
fi
[ ${#files[@]} -gt 0 ] || exit 0
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy -p build/fuzz --quiet 2> >(grep -v 'warnings generated' >&2)
echo "clang-tidy: ${#files[@]} files"

#!/usr/bin/env bash
# usage: bash tests/style.sh
# What tools can say of the style: clang-format finds nothing to change, no line is longer than 120 columns, and each room includes only those
# before it. Exits with 1 if something is otherwise.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mapfile -t files < <(git ls-files '*.hpp' '*.cpp')
bad=0
clang-format --dry-run --Werror "${files[@]}" 2>&1 | grep -m 20 'error:' && bad=1
awk 'length > 120 { print FILENAME ":" FNR ": " length " columns"; found = 1 } END { exit found }' "${files[@]}" || bad=1

rooms=(mesh plane surface curvature control gradation quality remesh io)
for i in "${!rooms[@]}"; do
    room=${rooms[$i]}
    later=$(IFS='|'; echo "${rooms[*]:$((i + 1))}")
    [ -n "$later" ] || continue
    if grep -nE "^#include [\"<](gradus|\.\.)/($later)/" -r "include/gradus/$room" "src/$room"; then
        echo "$room includes a room that comes after it (see above); the order is: ${rooms[*]}" >&2
        bad=1
    fi
done
exit "$bad"

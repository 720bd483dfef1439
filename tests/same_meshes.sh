#!/usr/bin/env bash
# usage: bash tests/same_meshes.sh OLD NEW [MODELS]
# Meshes the models of the tests with two builds of gradus (the programs OLD and NEW) and compares meshes and sizes bit by bit. Names those
# that differ and exits with 1 if there are some. MODELS: a folder of further inputs.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: bash tests/same_meshes.sh OLD NEW [MODELS]" >&2; exit 2; }
old=$(realpath "$1") new=$(realpath "$2") more=${3:+$(realpath "$3")}
cd "$(dirname "${BASH_SOURCE[0]}")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --build build/release --target write_models > "$work/log" || { cat "$work/log" >&2; exit 2; }
build/release/tests/write_models "$work/models"

# What a program makes of an input: meshes with sizes, .vtu holding all bits; what it says counts where it refuses.
mesh() {  # PROGRAM FILE OUT OPTIONS
    "$1" remesh "$2" -o "$3" --threads 2 -q "${@:4}" 2> "$3.err" || cat "$3.err" > "$3.failed"
}

differ=0 count=0
compare() {  # NAME FILE OPTIONS
    mesh "$old" "$2" "$work/old.vtu" "${@:3}"
    mesh "$new" "$2" "$work/new.vtu" "${@:3}"
    count=$((count + 1))
    if ! cmp -s "$work/old.vtu" "$work/new.vtu" && ! cmp -s "$work/old.vtu.failed" "$work/new.vtu.failed"; then
        echo "differs: $1 ${*:3}"
        differ=$((differ + 1))
    fi
    rm -f "$work"/old.vtu* "$work"/new.vtu*
}

for file in "$work"/models/* ${more:+"$more"/*}; do
    name=$(basename "$file")
    case $name in
        teapot.bpt)
            compare "$name" "$file" --no-gradation
            compare "$name" "$file" --shock 1.5
            compare "$name" "$file" --fast
            ;;
        *.bpt) compare "$name" "$file" ;;
        *)
            compare "$name" "$file"
            compare "$name" "$file" --chord-error 0.005
            ;;
    esac
done
echo "$count meshes, $differ differ"
[ "$differ" -eq 0 ]

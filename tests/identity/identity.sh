#!/usr/bin/env bash
# identity.sh FOLDER RUNNER COMPILER [FLAG...]: builds the library and trace.c into FOLDER, runs it under RUNNER (an
# emulator with its arguments in one word, or nothing) and compares its hashes with expected.txt.
# Where the compiler (with a C library to link) or the emulator cannot be had it says so and exits with 77.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
lib=$here/../../lib

folder=$1
read -ra runner <<<"$2"
shift 2
for program in "$1" "${runner[@]:0:1}"; do
    command -v "$program" >/dev/null || {
        echo "skipped: there is no $program on this machine"
        exit 77
    }
done
mkdir -p "$folder"
echo 'int main(void) { return 0; }' >"$folder/empty.c"
"$@" -static "$folder/empty.c" -o "$folder/empty" 2>"$folder/log.txt" || {
    echo "skipped: not even an empty program builds with: $*"
    head -n 3 "$folder/log.txt"
    exit 77
}
"$@" -static -I "$lib/include" -I "$lib/src" "$lib"/src/*/*.c "$here/trace.c" -o "$folder/trace"
"${runner[@]}" "$folder/trace" | diff "$here/expected.txt" - && echo "the same hashes: $*"

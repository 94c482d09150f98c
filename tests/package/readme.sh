#!/bin/sh
# The README's firmware example, compiled as it stands, linked with the library and run: readme.sh README LIB_DIR WORK_DIR CC...
set -eu
readme=$1 lib=$2 work=$3
shift 3
here=$(dirname "$0")
mkdir -p "$work"
awk '/^## .*firmware/ { here = 1 } here && /^```$/ { exit } code { print } here && /^```c$/ { code = 1 }' "$readme" >"$work/example.c"
[ -s "$work/example.c" ] || {
    echo "no C example under a heading with 'firmware' in $readme" >&2
    exit 1
}
"$@" -std=c11 -Wall -Wextra -Wpedantic -Wconversion -Wno-missing-prototypes -Werror -ffp-contract=off -I "$lib/include" \
    "$work/example.c" "$here/readme_board.c" "$lib"/src/*.c -o "$work/example"
"$work/example"

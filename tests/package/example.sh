#!/bin/sh
# The C example of a page, compiled as it stands, linked with the library and a board, and run:
# example.sh PAGE HEADING BOARD_C INCLUDE_DIR LIBRARY WORK_DIR CC... takes the first one below a heading that matches HEADING.
set -eu
page=$1 heading=$2 board=$3 include=$4 library=$5 work=$6
shift 6
mkdir -p "$work"
awk -v heading="^## .*$heading" '$0 ~ heading { here = 1 } here && /^```$/ { exit } code { print } here && /^```c$/ { code = 1 }' \
    "$page" >"$work/example.c"
[ -s "$work/example.c" ] || {
    echo "no C example under a heading with '$heading' in $page" >&2
    exit 1
}
"$@" -std=c11 -Wall -Wextra -Wpedantic -Wconversion -Wno-missing-prototypes -Werror -ffp-contract=off -I "$include" \
    "$work/example.c" "$board" "$library" -o "$work/example" -lm
"$work/example"

#!/usr/bin/env bash
# linkage.sh LIB OUT COMPILER [FLAG...]: LIB/src compiled with -fpic and -fno-jump-tables. It must hold no absolute address, so
# that a program can carry it anywhere without relocating it, and define no global symbol but tribo_*.
set -euo pipefail

lib=$1 out=$2
shift 2

rm -rf "$out"
mkdir -p "$out"
for source in "$lib"/src/*/*.c; do
    "$@" -std=c11 -O2 -ffreestanding -fpic -fno-jump-tables -I "$lib/include" -ffp-contract=off -c "$source" -o "$out/$(basename "$source" .c).o"
done

failed=0
for object in "$out"/*.o; do
    # Sections of a program (not .debug_*, .eh_frame) and their relocations that are filled with an address.
    absolute=$(readelf -rW "$object" | awk '
        /^Relocation section/ { allocated = $3 !~ /debug|eh_frame/; section = $3 }
        allocated && $3 ~ /^R_(X86_64_(64|32S?|16|8)|386_(32|16|8)|ARM_(ABS(32|16|12|8)|TARGET1|MOV[WT]_ABS.*|THM_MOV[WT]_ABS.*)|AARCH64_ABS.*|RISCV_(32|64|HI20))$/ {
            print section, $3, $5 }' | sort -u | head -n 3)
    name=$(basename "$object" .o)
    if [ -n "$absolute" ]; then
        echo "linkage.sh: $name holds absolute addresses: $absolute" >&2
        failed=1
    fi
done
if others=$(nm --defined-only --extern-only "$out"/*.o | awk 'NF == 3 && $3 !~ /^tribo_/ { print $3 }' | grep .); then
    echo "linkage.sh: global symbols without the prefix tribo_: $others" >&2
    failed=1
fi
exit $failed

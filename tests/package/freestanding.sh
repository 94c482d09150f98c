#!/usr/bin/env bash
# freestanding.sh LIB OUT COMPILER [FLAG...]: compiles LIB/src with the headers of a freestanding compiler only, with -fpic and
# -fno-jump-tables, and checks the objects. They leave undefined memcpy and memset, which a compiler may call on its own, and the helpers of
# integer and floating-point arithmetic: no libc, no libm. They define no global symbol but tribo_*. They hold no absolute address, so
# that a program can carry them anywhere without relocating them.
set -euo pipefail

lib=$1 out=$2
shift 2
# Where stdint.h and the like are that come with the compiler.
headers=$(dirname "$("$@" -print-file-name=include/stdint.h)")

rm -rf "$out"
mkdir -p "$out"
for source in "$lib"/src/*/*.c; do
    "$@" -std=c11 -O2 -ffreestanding -fpic -fno-jump-tables -nostdinc -isystem "$headers" -I "$lib/include" -ffp-contract=off \
        -Wall -Wextra -Werror -c "$source" -o "$out/$(basename "$source" .c).o"
done

undefined=$(nm --undefined-only "$out"/*.o | awk '$1 == "U" {print $2}' | sort -u)
defined=$(nm --defined-only "$out"/*.o | awk 'NF == 3 {print $3}' | sort -u)
extern=$(comm -23 <(echo "$undefined") <(echo "$defined"))
echo "left to others: ${extern//$'\n'/ }"

failed=0
arm='mem(cpy|set|clr)[48]?|[fd](add|sub|rsub|mul|div|2u?iz|cmp[a-z]+)|c[fd][a-z]*cmp[a-z]+|d2f|f2d|u?i2d|u?[il]2f|u?idiv(mod)?|u?ldivmod|l(mul|lsl|lsr|asr)'
if unexpected=$(grep -vxE "|memcpy|memset|_GLOBAL_OFFSET_TABLE_|__clz[sd]i2|__aeabi_($arm)" <<<"$extern"); then
    echo "freestanding.sh: not allowed in the library: ${unexpected//$'\n'/ }" >&2
    failed=1
fi
for object in "$out"/*.o; do
    # Sections of a program (not .debug_*, .eh_frame) and their relocations that are filled with an address.
    absolute=$(readelf -rW "$object" | awk '
        /^Relocation section/ { allocated = $3 !~ /debug|eh_frame/; section = $3 }
        allocated && $3 ~ /^R_(X86_64_(64|32S?|16|8)|386_(32|16|8)|ARM_(ABS(32|16|12|8)|TARGET1|MOV[WT]_ABS.*|THM_MOV[WT]_ABS.*)|AARCH64_ABS.*|RISCV_(32|64|HI20))$/ {
            print section, $3, $5 }' | sort -u | head -n 3)
    if [ -n "$absolute" ]; then
        echo "freestanding.sh: $(basename "$object" .o) holds absolute addresses: $absolute" >&2
        failed=1
    fi
done
if others=$(nm --defined-only --extern-only "$out"/*.o | awk 'NF == 3 && $3 !~ /^tribo_/ { print $3 }' | grep .); then
    echo "freestanding.sh: global symbols without the prefix tribo_: $others" >&2
    failed=1
fi
exit $failed

#!/usr/bin/env bash
# freestanding.sh LIB OUT COMPILER [FLAG...]: compiles LIB/src with the headers of a freestanding compiler only
# and checks what the objects leave undefined: memcpy and memset, which a compiler may call on its own, and the
# helpers of integer and floating-point arithmetic. No libc, no libm.
set -euo pipefail

lib=$1 out=$2
shift 2
# Where stdint.h and the like are that come with the compiler.
headers=$(dirname "$("$@" -print-file-name=include/stdint.h)")

rm -rf "$out"
mkdir -p "$out"
for source in "$lib"/src/*/*.c; do
    "$@" -std=c11 -O2 -ffreestanding -nostdinc -isystem "$headers" -I "$lib/include" -ffp-contract=off \
        -Wall -Wextra -Werror -c "$source" -o "$out/$(basename "$source" .c).o"
done

undefined=$(nm --undefined-only "$out"/*.o | awk '$1 == "U" {print $2}' | sort -u)
defined=$(nm --defined-only "$out"/*.o | awk 'NF == 3 {print $3}' | sort -u)
extern=$(comm -23 <(echo "$undefined") <(echo "$defined"))
echo "left to others: ${extern//$'\n'/ }"

arm='mem(cpy|set|clr)[48]?|[fd](add|sub|rsub|mul|div|2u?iz|cmp[a-z]+)|c[fd][a-z]*cmp[a-z]+|d2f|f2d|u?i2d|u?i2f|u?idiv(mod)?|u?ldivmod|l(mul|lsl|lsr|asr)'
if unexpected=$(grep -vxE "|memcpy|memset|__clz[sd]i2|__aeabi_($arm)" <<<"$extern"); then
    echo "freestanding.sh: not allowed in the library: ${unexpected//$'\n'/ }" >&2
    exit 1
fi

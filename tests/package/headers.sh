#!/usr/bin/env bash
# headers.sh INCLUDE_DIR COMPILER [FLAG...]: each public header compiles as the only one, and twice.
set -euo pipefail

include=$1
shift
for header in "$include"/tribo/*.h; do
    name=tribo/$(basename "$header")
    printf '#include "%s"\n#include "%s"\ntypedef int not_empty;\n' "$name" "$name" |
        "$@" -fsyntax-only -pedantic-errors -Wall -Wextra -Werror -I "$include" -
    echo "$name"
done

#!/usr/bin/env bash
# refused.sh MESSAGE COMPILER [FLAG...]: these flags must stop each source that computes in float with MESSAGE.
set -euo pipefail
lib=$(cd "$(dirname "$0")/../../lib" && pwd)

message=$1
shift
readarray -t sources < <(ls "$lib"/src/*/*_f32.c && grep -lE '[0-9]f\b' "$lib"/src/*/*_q31.c)
for source in "${sources[@]}"; do
    if errors=$("$@" -fsyntax-only -I "$lib/include" "$source" 2>&1); then
        echo "$source compiles: $*"
        exit 1
    fi
    grep -qF -e "$message" <<<"$errors" || {
        echo "$source fails with another message: $errors"
        exit 1
    }
done

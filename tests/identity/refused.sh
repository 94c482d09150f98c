#!/usr/bin/env bash
# refused.sh MESSAGE COMPILER [FLAG...]: these flags must stop each source that computes in float with MESSAGE.
set -euo pipefail
lib=$(cd "$(dirname "$0")/../../lib" && pwd)

message=$1
shift
for source in "$lib"/src/*_f32.c "$lib"/src/{arm,biquad,controller,force_loop,friction,headroom}_q31.c; do
    if errors=$("$@" -fsyntax-only -I "$lib/include" "$source" 2>&1); then
        echo "$source compiles: $*"
        exit 1
    fi
    grep -qF -e "$message" <<<"$errors" || {
        echo "$source fails with another message: $errors"
        exit 1
    }
done

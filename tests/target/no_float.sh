#!/usr/bin/env bash
# no_float.sh NM PROGRAM: a program with the Q31 loop and params from the host has no float in it, nor a helper for one.
set -euo pipefail

if "$1" "$2" | grep -E '__aeabi_[a-z0-9]*f|__[a-z0-9]*sf[0-9a-z]*$|_f32'; then
    echo "no_float.sh: not allowed in $2" >&2
    exit 1
fi

#!/usr/bin/env bash
# axis_alone.sh NM PROGRAM: a program with an axis and its PI links neither the paper's method nor the check of sections.
set -euo pipefail

symbols=$("$1" "$2")
grep -q ' tribo_axis_f32_step$' <<<"$symbols"
if grep -E 'tribo_(compensator|relay|force_loop_f32_(step|init)$|friction_f32_(init$|step)|arm_f32|controller_f32_(init$|prepare)|paper)' <<<"$symbols"; then
    echo "axis_alone.sh: not allowed in $2" >&2
    exit 1
fi

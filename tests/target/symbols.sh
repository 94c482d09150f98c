#!/usr/bin/env bash
# symbols.sh NM ARCHIVE: what each object of the cross-compiled library leaves to others. Nothing but each other, what a
# compiler may call on its own (memcpy, memset), and its helpers: of integers anywhere, of single precision only where
# numbers are float, of double only in the headroom. No libc, no libm.
set -euo pipefail

nm=$1 archive=$2

integer='mem(cpy|set)|__aeabi_(mem(cpy|set|clr)[48]?|u?idiv(mod)?|l(mul|lsl|lsr|asr|cmp)|ulcmp)'
integer+='|__(mul|ashl|lshr|ashr)di3|__(u?div|u?mod)si3|__clzsi2|__gnu_thumb1_case_[a-z]+'
single='__aeabi_(f(add|sub|rsub|mul|div|2u?iz|cmp[a-z]+)|cf[a-z]*cmp[a-z]+|u?[il]2f)'
single+='|__(add|sub|mul|div)sf3|__(eq|ne|lt|le|gt|ge|unord)sf2|__fix(uns)?sfsi|__float(un)?[sd]isf'
double='__aeabi_(d(add|sub|rsub|mul|div|2f|cmp[a-z]+)|cd[a-z]*cmp[a-z]+|f2d|u?i2d)'
double+='|__(add|sub|mul|div)df3|__(eq|ne|lt|le|gt|ge|unord)df2|__extendsfdf2|__truncdfsf2|__float(un)?sidf'

# The set-up of Q31 is in float, on purpose, and so are configs, the check of ranges and the search for a refused number; a drive
# whose params come from the host links none of them (no_float.sh). What learns is in float for both, outside the tick.
"$nm" "$archive" | awk -v integer="^($integer)\$" -v single="^($single)\$" -v double="^($double)\$" '
    /:$/ { object = $1 }
    NF == 3 { defined[$3] = 1 }
    $1 == "U" { used[++count] = object " " $2 }
    END {
        for (i = 1; i <= count; i++) {
            split(used[i], of, " ")
            if (of[2] in defined) continue
            print used[i]
            floats = of[1] ~ /(_f32|_q31)[.]|^(axis_config|joint_config|learner|ranges|refusal)[.]/
            if (of[2] !~ integer && !(floats && of[2] ~ single) && !(of[1] ~ /^headroom_q31[.]/ && of[2] ~ double)) {
                print "symbols.sh: " used[i] ": not allowed there" >"/dev/stderr"
                failed = 1
            }
        }
        exit failed
    }'

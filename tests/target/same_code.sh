#!/bin/sh
# same_code.sh OBJCOPY LIBRARY OTHER...: fails unless the libraries of each two are the same to the byte, but for the attribute
# that names the processor.
set -eu
objcopy=$1
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
while [ $# -gt 0 ]; do
    "$objcopy" -D -R .ARM.attributes "$1" "$folder/one.a"
    "$objcopy" -D -R .ARM.attributes "$2" "$folder/other.a"
    cmp "$folder/one.a" "$folder/other.a" || {
        echo "$1 and $2 differ: remove same_code from cmake/boards.json, so that the unit and contract tests run on both" >&2
        exit 1
    }
    shift 2
done

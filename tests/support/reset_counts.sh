#!/bin/sh
# reset_counts.sh TREE SOURCES: removes the counts of earlier runs, and what gcc has noted of sources that are gone.
set -eu
find "$1" -name '*.gcda' -delete
find "$1" -name '*.gcno' | while read -r notes; do
    source=$2/${notes#*.dir/}
    [ -e "${source%.gcno}" ] || rm "$notes"
done

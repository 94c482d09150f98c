# For the scripts of the project, which source it: --help prints the comment at a script's top, --version the version.

at_most() { # N "$@": refuses more than N arguments
    if [ $# -gt $(($1 + 1)) ]; then
        shift $(($1 + 1))
        echo "$0: '$1' is one argument too many; see --help" >&2
        exit 2
    fi
}
root=$(cd "$(dirname "$0")" && until [ -e lib/include/tribo/status.h ]; do cd ..; done && pwd -P)
case "${1-}" in
    -h | --help)
        sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0"
        exit
        ;;
    --version)
        echo "$(realpath --relative-to="$root" "$0") $(sed -n 's/.*TRIBO_VERSION_STRING "\(.*\)"/\1/p' "$root/lib/include/tribo/status.h")"
        exit
        ;;
esac

# For the scripts beside it, which source it: --help prints the comment at a script's top, --version the version.
case "${1-}" in
    -h | --help)
        sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0"
        exit
        ;;
    --version)
        echo "tools/${0##*/} $(sed -n 's/.*TRIBO_VERSION_STRING "\(.*\)"/\1/p' "$(dirname "$0")/../lib/include/tribo/status.h")"
        exit
        ;;
esac

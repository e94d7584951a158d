# A Debian 13 with packages that only checks need. Checks source this file.
#   own_debian NAME PACKAGE …   makes it, once in build/check; exits with 77 if that is impossible
#   in_own_debian COMMAND …     becomes COMMAND in it
# Outside a root file system the machine must have the packages.

unavailable() {
    say "$*"
    exit 77
}

own_debian() {
    local name=$1
    shift
    packages=("$@")
    if [ "$way" != rootfs ]; then
        dpkg-query -W "$@" >/dev/null 2>&1 || unavailable "install the packages $*"
        return
    fi
    root=$repo/build/check/$name-root
    [ ! -d "$root" ] || return 0
    why=
    rootfs_possible || unavailable "a Debian 13 with $* cannot be made: $why"
    mkdir -p "$repo/build/check"
    new=$(mktemp -d "$repo/build/check/new.XXXXXX")
    trap 'rm -rf --one-file-system "$new"' EXIT
    trap 'exit 130' INT TERM HUP
    log=$new/log
    need_space "$new" 2
    rootfs_from_mirrors with_packages || unavailable "a Debian 13 with $* cannot be made: $why"
    rm -rf --one-file-system "$new"
    trap - EXIT INT TERM HUP
}

with_packages() {
    local bootstrap bundle
    rootfs_options
    bootstrap+=("--include=$(IFS=,; echo "${packages[*]}"),bubblewrap")
    rootfs_fill "$1"
}

in_own_debian() { if [ "$way" = rootfs ]; then rootfs_enter "$@"; else enter "$@"; fi; }

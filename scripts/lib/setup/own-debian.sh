# own_debian NAME PACKAGE …: for a check that needs packages which users do not. Where `ready` has found the native way, they have to be there;
# otherwise $root becomes a Debian 13 of its own with them, made once in build/check. Ends with 77 where neither is to be had.

left_out() {
    say "$*"
    exit 77
}

own_debian() {
    local name=$1
    shift
    wanted=("$@")
    if [ "$way" = native ]; then
        dpkg-query -W "$@" >/dev/null 2>&1 || left_out "needs the packages $*"
        return
    fi
    root=$repo/build/check/$name-root
    [ ! -d "$root" ] || return 0
    why=
    rootfs_possible || left_out "needs a Debian 13 with the packages $*: $why"
    mkdir -p "$repo/build/check"
    new=$(mktemp -d "$repo/build/check/new.XXXXXX")
    trap 'rm -rf --one-file-system "$new"' EXIT
    trap 'exit 130' INT TERM HUP
    log=$new/log
    need_space "$new" 2
    rootfs_from_mirrors with_wanted || left_out "needs a Debian 13 with the packages $*: $why"
    rm -rf --one-file-system "$new"
    trap - EXIT INT TERM HUP
}

with_wanted() {
    local bootstrap
    rootfs_options
    bootstrap+=("--include=$(IFS=,; echo "${wanted[*]}"),bubblewrap")
    rootfs_fill "$1"
}

in_own_debian() { if [ "$way" = native ]; then enter "$@"; else rootfs_enter "$@"; fi; }

# The environment that everything here runs in: YADE, its headers, a compiler, Python.
#
#   ready             makes it if it is not there; afterwards needs no network and about 0.1 s
#   build             brings the compiled modules up to date
#   enter COMMAND …   becomes COMMAND in it (exec)
#
# It is one of two, tried in this order, each in a file of its own:
#   native.sh   this machine, if its Debian has YADE
#   rootfs.sh   a Debian 13 root file system in the user's cache
#
# Source this file from a bash script of this repository.

set -euo pipefail

yade_version=2025.2.0
lib=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
setup=$lib/setup
repo=$(cd "$lib/../.." && pwd -P)
cache=${XDG_CACHE_HOME:-${HOME:?or XDG_CACHE_HOME must be set}/.cache}/yade-rcr
log=$cache/log
etc=${YADE_RCR_ETC:-/etc} # the tests put another in its place

say() { echo "yade-rcr: $*" >&2; }

fail() {
    say "$*"
    exit 1
}

# Whatever is read goes to the log; the lines meant for the user go to the terminal too.
record() { tee -a "$log" "$new/output" | grep --line-buffered '^yade-rcr: ' >&2 || true; }

required_packages() { sed -n 's/^\([a-z][^ ]*\).*/\1/p' "$setup/packages"; }
packages_id() { sed 's/#.*//; /^ *$/d' "$setup/packages" | sha256sum | cut -c1-12; }

# lock PATH NOTICE [MARK]: held until `unlock`, or the end of this process. Who waits is told why; with a MARK
# only while that file is there, since until then the other one looks whether there is something to do.
lock() {
    exec 9<"$1"
    until flock -w "${YADE_RCR_PATIENCE:-0.5}" 9; do
        [ -z "${3:-}" ] || [ -e "$3" ] || continue
        say "$2"
        flock 9
        return
    done
}
unlock() { exec 9<&-; }

. "$setup/native.sh"
. "$setup/rootfs.sh"

# ready_way: sets `way` to the environment that is complete, if there is one
ready_way() {
    for way in native rootfs; do
        "${way}_ready" && return
    done
    return 1
}

ready() {
    way=${YADE_RCR_WAY:-} # already inside
    [ -z "$way" ] && ! ready_way || return 0
    mkdir -p "$cache" || fail "cannot write $cache: set XDG_CACHE_HOME to a directory with 5 GB free"
    lock "$cache" "waiting for another set-up in $cache …"
    ready_way || make_environment
    unlock
}

make_environment() {
    rm -rf --one-file-system "$cache"/new.* # left by an interrupted set-up
    : >"$log"
    new=$(mktemp -d "$cache/new.XXXXXX")
    trap 'rm -rf --one-file-system "$new"' EXIT
    trap 'exit 130' INT TERM HUP
    for way in native rootfs; do
        if "${way}_possible" && "${way}_make"; then
            rm -rf --one-file-system "$new"
            trap - EXIT INT TERM HUP
            return
        fi
    done
    fail "no environment could be made: ${why:-see above}; log: $log"
}

# need_space DIRECTORY GB
need_space() {
    local free
    free=$(df -Pk "$1" | awk 'NR == 2 { print int($4 / 1048576) }')
    [ "$free" -ge "$2" ] || fail "$1 has $free GB free, the set-up needs $2 GB: free some, or set XDG_CACHE_HOME elsewhere"
}

enter() {
    # OpenMP's waiting threads would spin and take the processors from the solver's own.
    export OMP_WAIT_POLICY=${OMP_WAIT_POLICY:-passive}
    export PYTHONPATH="$repo/py:$("${way}_yade_python")${PYTHONPATH:+:$PYTHONPATH}:$repo" # of $repo itself: benchmarks
    if [ -n "${YADE_RCR_WAY:-}" ]; then
        exec "$@"
    fi
    export YADE_RCR_WAY=$way
    export YADE_RCR_COMMIT=${YADE_RCR_COMMIT:-$(git -C "$repo" describe --always --dirty=+ --abbrev=12 --exclude='*' 2>/dev/null || true)}
    "${way}_enter" "$@"
}

build() {
    local source id working=$repo/build/working
    source=$("${way}_source")
    id="$way $yade_version $source $(packages_id)"
    [ -w "$repo" ] || { say "$repo is not writable: running what was built there" && return; }
    lock "$repo" "waiting for another build in $repo …" "$working"
    rm -f "$working" # left by an interrupted build
    (
        cd "$repo"
        unset CC CXX CFLAGS CXXFLAGS CPPFLAGS LDFLAGS CMAKE_PREFIX_PATH
        if [ "$(cat build/environment 2>/dev/null)" != "$id" ]; then
            rm -rf build
            mkdir build
            : >"$working"
            quietly cmake -S "$repo" -B "$repo/build" -G Ninja -DYADE_SOURCE_DIR="$source"
            echo "$id" >build/environment
        fi
        quietly cmake --build "$repo/build" --parallel "$(build_jobs)"
    )
    rm -f "$working"
    unlock
}

# As many compilers as there are processors, but each takes up to 3.5 GB.
build_jobs() {
    awk -v processors="$(nproc)" '/^MemAvailable/ { jobs = int($2 / 3.5e6) }
        END { print jobs < 1 ? 1 : jobs < processors ? jobs : processors }' /proc/meminfo
}

# quietly COMMAND…: one line once it has something to do, its whole output if it fails
quietly() {
    local output=$repo/build/output announced=
    if ! (enter "$@") 2>&1 | while IFS= read -r line; do
        case $line in
        "["[!0]*) # [0/1]: looking for new files
            [ -n "$announced" ] || say "building (2 to 5 min from scratch) …"
            announced=yes
            : >"$repo/build/working"
            ;;
        esac
        printf '%s\n' "$line"
    done >"$output"; then
        cat "$output" >&2
        fail "the build failed, see above"
    fi
}

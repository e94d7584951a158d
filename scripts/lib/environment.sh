# The environment of all scripts: YADE, its headers, a compiler, Python.
#
#   ready             sets the environment up if it is missing; else takes 0.1 s and no network
#   build             brings the compiled modules up to date
#   enter COMMAND …   becomes COMMAND in the environment (exec)
#
# The environment is one of three, tried in this order:
#   setup/prefix.sh   a YADE of the user, in YADE_PREFIX
#   setup/native.sh   this machine, if its Debian or Ubuntu has YADE 2022.01a or later
#   setup/rootfs.sh   a Debian 13 root file system in the user's cache
#
# Bash scripts of this repository source this file.

set -euo pipefail

lib=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
setup=$lib/setup
repo=$(cd "$lib/../.." && pwd -P)
cache=${XDG_CACHE_HOME:-${HOME:?set HOME or XDG_CACHE_HOME}/.cache}/yade-rcr
log=$cache/log
etc=${YADE_RCR_ETC:-/etc} # tests set another directory
usr=${YADE_RCR_USR:-/usr} # as well

say() { echo "yade-rcr: $*" >&2; }

fail() {
    say "$*"
    exit 1
}

# may_install: as root with a writable /usr. In a root file system with the machine's /var, apt-get
# would change the machine's list of packages.
may_install() { [ "$(id -u)" = 0 ] && [ -w "$usr" ]; }

make_cache() {
    mkdir -p "$1" ||
        fail "cannot write $cache: set XDG_CACHE_HOME to a directory with 5 GB of free space"
}

if [ -z "${HOME:-}" ]; then # YADE needs one
    export HOME=$cache/home
    make_cache "$HOME"
fi

# stage TEXT: announces a stage of the set-up, "set-up 1/2: WORK (DURATION) …"
stage() {
    stage_done
    say "$1"
    echo "$SECONDS ${1%%:*}" >"$new/stage"
}

# stage_done: prints the duration of the present stage
stage_done() {
    local start name
    [ -e "$new/stage" ] || return 0
    read -r start name <"$new/stage"
    say "$name took $((SECONDS - start)) s"
    rm "$new/stage"
}

# record: copies its input to the log, and the lines for the user to the terminal
record() {
    local line
    tee -a "$log" "$new/output" | while IFS= read -r line; do
        case $line in
        "yade-rcr: set-up "*) stage "${line#yade-rcr: }" ;;
        "yade-rcr: "*) echo "$line" >&2 ;;
        esac
    done
}

required_packages() { sed -n 's/^\([a-z][^ ]*\).*/\1/p' "$setup/packages"; }
packages_id() { sed 's/#.*//; /^ *$/d' "$setup/packages" | sha256sum | cut -c1-12; }

# lock PATH NOTICE [MARK]: locks PATH until `unlock` or the end of this process. A waiting process
# prints NOTICE; with MARK only if that file exists, which the other process makes when it has work.
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

. "$setup/prefix.sh"
. "$setup/native.sh"
. "$setup/rootfs.sh"

# ready_way: sets `way` to the complete environment, if one exists
ready_way() {
    for way in prefix native rootfs; do
        "${way}_ready" && return
    done
    return 1
}

ready() {
    way=${YADE_RCR_WAY:-} # set inside the environment
    [ -z "$way" ] && ! ready_way || return 0
    make_cache "$cache"
    lock "$cache" "waiting for another set-up in $cache …"
    ready_way || make_environment
    unlock
}

make_environment() {
    rm -rf --one-file-system "$cache"/new.* # of an interrupted set-up
    : >"$log"
    new=$(mktemp -d "$cache/new.XXXXXX")
    trap 'rm -rf --one-file-system "$new"' EXIT
    trap 'exit 130' INT TERM HUP
    for way in native rootfs; do
        rm -f "$new/stage" # of an attempt that failed
        if "${way}_possible" && "${way}_make"; then
            stage_done
            rm -rf --one-file-system "$new"
            trap - EXIT INT TERM HUP
            return
        fi
    done
    fail "the environment cannot be set up: ${why:-see above}; log: $log"
}

# need_space DIRECTORY GB
need_space() {
    local free
    free=$(df -Pk "$1" | awk 'NR == 2 { print int($4 / 1048576) }')
    [ "$free" -ge "$2" ] ||
        fail "$1 has $free GB free, the set-up needs $2 GB: free some or set XDG_CACHE_HOME"
}

enter() {
    # Threads of OpenMP that wait must leave the processors to the threads of the solver.
    export OMP_WAIT_POLICY=${OMP_WAIT_POLICY:-passive}
    # UCX, which YADE loads with MPI, would take SIGHUP as its debug signal.
    export UCX_DEBUG_SIGNO=${UCX_DEBUG_SIGNO:-0}
    # $repo is for the package `benchmarks`.
    export PYTHONPATH="$repo/py:$("${way}_yade_python")${PYTHONPATH:+:$PYTHONPATH}:$repo"
    # A shell without job control starts commands in the background with Ctrl-C ignored.
    set -- env --default-signal=INT,QUIT "$@"
    if [ -n "${YADE_RCR_WAY:-}" ]; then
        exec "$@"
    fi
    export YADE_RCR_WAY=$way
    export YADE_RCR_COMMIT=${YADE_RCR_COMMIT:-$(commit)}
    "${way}_enter" "$@"
}

# commit: of the repository, with + if files differ from it; empty outside a clone
commit() {
    [ ! -e "$repo/.git" ] ||
        git -C "$repo" describe --always --dirty=+ --abbrev=12 --exclude='*' 2>/dev/null || true
}

build() {
    local source id working=$repo/build/working
    source=$("${way}_source")
    id="$repo $way $("${way}_version") $source $(packages_id)"
    [ -w "$repo" ] || { say "$repo is not writable: using its last build" && return; }
    lock "$repo" "waiting for another build in $repo …" "$working"
    rm -f "$working" # of an interrupted build
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

# build_jobs: one compiler a processor, within the memory; a compiler takes up to 3 GB
build_jobs() {
    awk -v processors="$(nproc)" '/^MemAvailable/ { jobs = int($2 / 3.5e6) }
        END { print jobs < 1 ? 1 : jobs < processors ? jobs : processors }' /proc/meminfo
}

# quietly COMMAND …: prints a line before and after COMMAND compiles, and its output if it fails
quietly() {
    local output=$repo/build/output start=$SECONDS
    rm -f "$output.begun"
    if ! (enter "$@") 2>&1 | while IFS= read -r line; do
        case $line in
        "["[!0]*) # [0/1] only checks for new files
            [ -e "$output.begun" ] || say "compiling (2 to 5 min from scratch on two processors) …"
            : >"$output.begun"
            : >"$repo/build/working"
            ;;
        esac
        printf '%s\n' "$line"
    done >"$output"; then
        cat "$output" >&2
        fail "the build failed, see above"
    fi
    [ ! -e "$output.begun" ] || say "compiling took $((SECONDS - start)) s"
}

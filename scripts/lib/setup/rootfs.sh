# A Debian 13 root file system in the cache as the environment. mmdebstrap makes it, bubblewrap and
# nsenter enter it. Its files belong to the user, so `rm -rf` removes it.

root=$cache/root-$(packages_id)
release=trixie # codename of the Debian that is made
# files of the machine's /etc that are bound over those of the root file system
machine_files=(resolv.conf hosts hostname localtime machine-id ssl/certs/ca-certificates.crt)

rootfs_version() { echo 2025.2.0; }
rootfs_source() { echo /usr/src/yade; }
rootfs_yade_python() { (cd "$root" && echo usr/lib/*/yade-double/py | sed 's|^|/|'); }

# A complete root file system gets the name $root. With YADE_SOURCE_DIR, the machine comes first.
rootfs_ready() { [ -d "$root" ] && [ -z "${YADE_SOURCE_DIR:-}" ] && command -v bwrap >/dev/null; }

rootfs_possible() {
    case $(uname -m) in
    x86_64 | aarch64) ;;
    *) why="Debian has YADE for amd64 and arm64; this is $(uname -m)" && return 1 ;;
    esac
    local tools="mmdebstrap bwrap" tool missing=
    [ "$(id -u)" = 0 ] || tools="$tools newuidmap"
    for tool in $tools; do
        command -v "$tool" >/dev/null || missing="$missing $tool"
    done
    missing=$(echo "$missing" | sed 's/bwrap/bubblewrap/; s/newuidmap/uidmap/')
    if [ -n "$missing" ] && may_install && command -v apt-get >/dev/null; then
        local start=$SECONDS
        say "installing$missing with apt-get (up to 1 min) …"
        { apt-get update; apt-get install -y --no-install-recommends $missing; } >>"$log" 2>&1 ||
            { why="apt-get cannot install$missing: check the network" && return 1; }
        say "installing$missing took $((SECONDS - start)) s"
    elif [ -n "$missing" ]; then
        why="${why:+$why, or }the tools for a root file system are missing"
        why="$why (on Debian and Ubuntu: apt-get install$missing)"
        return 1
    fi
    if [ "$(id -u)" != 0 ] && ! grep -q "^$(id -un):" "$etc/subuid"; then
        why="$(id -un) has no subordinate ids: run as root usermod --add-subuids 100000-165535"
        why="$why --add-subgids 100000-165535 $(id -un)"
        return 1
    fi
    (rootfs_hold --bind / / && rootfs_join true) 2>>"$log" ||
        { why="this system forbids user namespaces, which bubblewrap needs" && return 1; }
}

# rootfs_mirrors: prints sets of apt sources to try, one a line. The first has all Debian mirrors of
# this system's apt, with updates and security fixes; then come single mirrors; an empty line is the
# default of mmdebstrap.
rootfs_mirrors() {
    local codename known=
    codename=$(. "$etc/os-release" && [ "$ID" = debian ] && echo "${VERSION_CODENAME:-sid}") \
        2>/dev/null || codename=
    if [ -n "$codename" ]; then
        known=$(apt-get indextargets --no-release-info \
            --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
            awk -v to="$release" -v from="^($codename|oldstable|stable|testing|unstable|sid)\$" '
                $2 != "main"      { next }
                $1 ~ from         { print $3, to }
                $1 ~ "-updates$"  { print $3, to "-updates" }
                $1 ~ "-security$" { print $3, to "-security" }' | sort -u) || true
        echo "$known" | sed 's/.*/deb & main;/' | tr -d '\n'
        echo
        echo "$known" | sed -n "s/.* $release\$/deb & main/p"
    fi
    echo
}

rootfs_make() {
    [ ! -d "$root" ] || return 0 # only bubblewrap was missing
    need_space "$cache" 5
    [ "$(id -u)" = 0 ] || need_space /var/tmp 5
    stage "set-up 1/3: Debian 13 root file system (20 to 60 s) …"
    rootfs_from_mirrors rootfs_bootstrap && rootfs_finish
}

# rootfs_from_mirrors MAKE: calls `MAKE SOURCES`, which fills $new/tree, with one mirror after the
# other until it succeeds
rootfs_from_mirrors() {
    local sources
    while IFS= read -r sources; do
        mkdir "$new/tree"
        : >"$new/output"
        ! "$1" "$sources" || return 0
        rm -rf --one-file-system "$new/tree"
        why=$(rootfs_reason "$new/output")
        rm -f "$new/stage"
        say "$(mirror_names "$sources") failed: $why"
        # another mirror helps only if this one failed
        grep -q 'Failed to fetch\|apt-get update.*failed' "$new/output" || break
    done < <(rootfs_mirrors)
    return 1
}

mirror_names() {
    grep -oE '[a-z]+://[^ ;]+' <<<"$1" | sort -u | paste -sd ' ' | grep . ||
        echo "the default mirror"
}

# rootfs_reason OUTPUT: prints in a few words why the attempt failed
rootfs_reason() {
    if grep -q 'No space left' "$1"; then
        echo "the disk is full"
    elif grep -qE 'Temporary failure|Could not (resolve|connect)|unreachable' "$1" ||
        grep -qE 'Connection (failed|timed out)' "$1"; then
        echo "the mirror does not answer; check the network"
    elif grep -qE '^E: Failed to fetch' "$1"; then
        sed -nE 's/^E: Failed to fetch ([^ ]+) +(.*)/it does not deliver \1 (\2)/p' "$1" | tail -n 1
    else
        grep '^E: ' "$1" | tail -n 1
    fi
}

# rootfs_options: sets `bootstrap` to mmdebstrap for a small Debian, with the apt options of here,
# and `bundle` to the certificates
rootfs_options() {
    bundle=/etc/ssl/certs/ca-certificates.crt
    [ -r "$bundle" ] || bundle=/dev/null
    apt-config dump --no-empty --format '%f "%v";%n' Acquire |
        grep -E '^Acquire::(Check-|Retries|Force|https?::)' |
        grep -vi 'auto-\?detect' >"$new/apt.conf"
    bootstrap=(mmdebstrap --mode=unshare)
    [ "$(id -u)" != 0 ] || bootstrap=(unshare --mount mmdebstrap --mode=root)
    bootstrap+=(--variant=minbase
        --aptopt="$new/apt.conf" --aptopt='Acquire::Languages "none"' --dpkgopt=force-unsafe-io
        --setup-hook='mkdir -p "$1/etc/ssl/certs"'
        --setup-hook="upload '$bundle' /etc/ssl/certs/ca-certificates.crt")
}

# rootfs_bootstrap SOURCES: makes the root file system with the packages and YADE's headers
rootfs_bootstrap() {
    local bootstrap bundle
    local files="'$setup/install-packages' '$setup/fetch-source' '$setup/packages'"
    local fetch="chroot \"\$1\" /tmp/fetch-source $(rootfs_version) /usr/src/yade /tmp/apt >&2"
    local libraries="YADE, a compiler and Python libraries (1 to 7 min) …"
    rootfs_options
    bootstrap+=(--dpkgopt='path-exclude=/usr/share/doc/*'
        --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*'
        --dpkgopt='path-exclude=/usr/lib/*/yade-[!d]*' # builds in higher precision
        --customize-hook="copy-in $files /tmp"
        --customize-hook="echo 'yade-rcr: set-up 2/3: $libraries' >&2"
        --customize-hook='chroot "$1" /tmp/install-packages /tmp/packages >&2'
        --customize-hook="upload '$bundle' /etc/ssl/certs/ca-certificates.crt"
        --customize-hook='echo "yade-rcr: set-up 3/3: headers of YADE (15 MB, up to 1 min) …" >&2'
        --customize-hook="$fetch")
    rootfs_fill "$1" && [ -d "$new/tree/usr/src/yade/core" ]
}

# rootfs_fill SOURCES: runs `bootstrap` into $new/tree. Without root rights the result passes
# through an archive, so that the files belong to the user.
rootfs_fill() {
    local sources
    IFS=';' read -ra sources <<<"$1"
    if [ "$(id -u)" = 0 ]; then
        rootfs_bootstrap_into "$new/tree" 2>&1 | record
    else
        { TMPDIR=/var/tmp rootfs_bootstrap_into - 2>&1 >&3 | record; } 3>&1 |
            tar -x -C "$new/tree" --exclude='./dev/*' 2>>"$log"
    fi
}

# rootfs_bootstrap_into TARGET: runs `bootstrap` without open files. mmdebstrap gives numbers of files
# to a shell that knows only numbers up to 9.
rootfs_bootstrap_into() (
    local file
    for file in /proc/self/fd/*; do
        file=${file##*/}
        [ "$file" -le 2 ] || exec {file}>&-
    done
    exec "${bootstrap[@]}" "$release" "$1" "${sources[@]}"
)

# rootfs_finish: removes directories that the machine's replace, makes targets for bound files
rootfs_finish() {
    local file
    chmod -R u+rwX "$new/tree"
    rm -rf --one-file-system "$new"/tree/{boot,dev,home,media,mnt,opt,proc,root,run,srv,sys,tmp,var}
    for file in "${machine_files[@]}"; do
        rm -f "$new/tree/etc/$file"
        : >"$new/tree/etc/$file"
    done
    mv "$new/tree" "$root"
    # root file systems that were not entered for a month
    find "$cache" -maxdepth 1 -name 'root-*' -mtime +30 -exec rm -rf --one-file-system {} +
}

# rootfs_enter COMMAND …: /usr and /etc are those of the root file system. All other directories are
# the machine's, and so are files under /usr and /etc that the arguments name.
rootfs_enter() {
    local directory link file binds=()
    for directory in /*; do
        if [ -d "$directory" ] && ! rootfs_shadows "$directory"; then
            binds+=(--bind "$directory" "$directory")
        fi
    done
    for link in "$root"/{bin,sbin,lib*}; do
        [ ! -L "$link" ] || binds+=(--symlink "$(readlink "$link")" "${link#"$root"}")
    done
    for file in "${machine_files[@]}"; do
        binds+=(--ro-bind-try "/etc/$file" "/etc/$file")
    done
    rootfs_bind_paths "$PWD" "$repo" "${HOME:-/}" "$@"

    touch -c "$root" # in use: see rootfs_finish
    rootfs_hold --ro-bind "$root/usr" /usr --ro-bind "$root/etc" /etc "${binds[@]}" \
        --dev-bind /dev /dev --ro-bind-data 7 /etc/passwd --ro-bind-data 8 /etc/group \
        --chdir "$PWD" 7< <(cat /etc/passwd; getent passwd "$(id -u)") \
        8< <(cat /etc/group; getent group "$(id -g)")
    rootfs_join "$@"
}

# rootfs_hold OPTION …: makes a file system by the options of bubblewrap, sets `holder` to the id of
# a process in it. The process ends after a minute or at `rootfs_join`; init is its parent.
rootfs_hold() {
    exec 6< <(bwrap "$@" sh -c 'echo $$; exec sleep 60' 2>&1 &)
    wait $!
    read -r holder <&6 && [[ $holder = +([0-9]) ]] ||
        fail "bubblewrap cannot make the root file system: ${holder:-no answer}"
    exec 6<&-
}

# rootfs_join COMMAND …: becomes COMMAND in the file system of `holder`. The process stays the same,
# so that signals, the terminal and the exit status are those of COMMAND.
rootfs_join() {
    local nsenter options=(--target "$holder" --mount --wd)
    nsenter=$(command -v nsenter)
    [ "$(id -u)" = 0 ] || options+=(--user --preserve-credentials)
    unset LD_LIBRARY_PATH LD_PRELOAD PYTHONHOME
    export LC_ALL=C.UTF-8 PATH=/usr/bin:/bin
    exec "$nsenter" "${options[@]}" sh -c 'kill -KILL "$0"; exec "$@"' "$holder" "$@"
}

# rootfs_bind_paths WORD …: adds files under /usr and /etc that the words name to `binds`
rootfs_bind_paths() {
    local word previous= words=() paths path
    for word in "$@"; do
        case "$previous $word" in
        "--out "* | *" --out="*) rootfs_make_output "${word#--out=}" ;;
        esac
        previous=$word
        word=${word#--*=}
        words+=("${word:-.}")
    done
    # as written, and with symbolic links resolved
    mapfile -d '' paths < <(realpath -zms -- "${words[@]}"; realpath -zm -- "${words[@]}")
    for path in "${paths[@]}"; do
        if rootfs_shadows "$path"; then
            rootfs_bind "$path"
        fi
    done
}

# rootfs_shadows PATH: PATH lies in /usr or /etc, or in /usr by a symbolic link such as /bin
rootfs_shadows() {
    local top=${1#/}
    top=${top%%/*}
    [ "$top" = usr ] || [ "$top" = etc ] || [ -L "$root/$top" ]
}

# rootfs_owns PATH: the root file system has files in PATH, other than empty targets of binds
rootfs_owns() { [ -n "$(find "$root$1" -not -type d -not -size 0 -print -quit 2>/dev/null)" ]; }

# rootfs_bind PATH: adds the existing part of PATH to `binds`
rootfs_bind() {
    local path=$1
    until [ -e "$path" ] || [ -z "$path" ]; do path=${path%/*}; done
    [ -n "$path" ] || return 0 # the command reports a missing path
    ! rootfs_owns "$path" || return 0
    if [ ! -d "$path" ] && ! rootfs_owns "${path%/*}"; then
        path=${path%/*} # a script may need files beside it
    fi
    if [ -d "$path" ]; then
        mkdir -p "$root$path"
    else
        mkdir -p "$root${path%/*}"
        : >>"$root$path"
    fi
    binds+=(--bind "$path" "$path")
}

# rootfs_make_output PATH: makes an output in a directory of the root file system, to bind it
rootfs_make_output() {
    local path directory
    [ -n "$1" ] || return 0
    path=$(realpath -m -- "$1")
    directory=$path
    until [ -d "$directory" ] || [ -z "$directory" ]; do directory=${directory%/*}; done
    [ -n "$directory" ] || return 0
    if [ ! -e "$path" ] && rootfs_shadows "$path" && rootfs_owns "$directory"; then
        case ${path##*/} in
        *.*) mkdir -p "${path%/*}" && : >"$path" ;;
        *) mkdir -p "$path" ;;
        esac
    fi
}

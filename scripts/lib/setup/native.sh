# The machine as the environment: a Debian or Ubuntu with YADE 2022.01a or later, and the other
# packages. No package has YADE's headers. They come from YADE_SOURCE_DIR if it is set, else from
# YADE's source archive, unpacked in the cache.

oldest_yade=2022.01a

# version_of VERSION: prints a version of a package without the revision of Debian, if it is served
version_of() {
    local version=${1%-*}
    [ "$(printf '%s\n' "$oldest_yade" "$version" | sort -V | head -n 1)" = "$oldest_yade" ] &&
        echo "$version"
}

# native_version: prints the version of the installed YADE
native_version() {
    local version
    version=$(dpkg-query -W -f '${source:Version}' libyade 2>&1) && version_of "$version"
}

# native_offer: prints the version of YADE that apt can install
native_offer() {
    local offer
    offer=$(apt-cache policy libyade 2>&1 | sed -n 's/^  Candidate: \([0-9].*\)/\1/p')
    [ -n "$offer" ] && version_of "$offer"
}

native_installed() {
    native_version >/dev/null &&
        [ "$(dpkg-query -W -f '${db:Status-Status}\n' $(required_packages) 2>&1 |
            sort -u)" = installed ]
}

native_source() { echo "${YADE_SOURCE_DIR:-$cache/source-$(native_version)}"; }
native_yade_python() { echo /usr/lib/*/yade-double/py; }

native_ready() {
    [ -z "${YADE_SOURCE_DIR:-}" ] || [ -e "$YADE_SOURCE_DIR/core/Scene.hpp" ] ||
        fail "YADE_SOURCE_DIR = $YADE_SOURCE_DIR has no core/Scene.hpp; give YADE's sources"
    native_installed && [ -d "$(native_source)" ]
}

native_possible() {
    native_installed && return
    (. "$etc/os-release" && [[ $ID = debian || $ID = ubuntu ]]) 2>/dev/null || return 1
    if may_install; then
        native_offer >/dev/null || { apt-get update >>"$log" 2>&1 && native_offer >/dev/null; }
        return
    fi
    native_offer >/dev/null || return 1
    why="an administrator can install YADE's packages (apt-get install$(native_missing))"
    return 1
}

native_missing() {
    for package in $(required_packages); do
        dpkg-query -W "$package" >/dev/null 2>&1 || printf ' %s' "$package"
    done
}

# The headers come first: without them no package is installed.
native_make() {
    local version source
    version=$(native_version || native_offer)
    source=${YADE_SOURCE_DIR:-$cache/source-$version}
    if [ ! -d "$source" ]; then
        stage "set-up 1/2: headers of YADE $version from its source archive (up to 1 min) …"
        native_fetch "$version" 2>&1 | record || {
            say "no source archive of YADE $version found (YADE_SOURCE_DIR=FOLDER names one):" \
                "trying a root file system"
            return 1
        }
        mv "$new/source" "$source"
    fi
    native_installed && return
    need_space /usr 4
    stage "set-up 2/2: YADE, a compiler and Python libraries by apt-get (2 to 5 min) …"
    "$setup/install-packages" "$setup/packages" 2>&1 | record ||
        { say "the packages cannot be installed here: trying a root file system"; return 1; }
}

native_fetch() {
    if [ "$(id -u)" = 0 ] && ! { command -v bzip2 && command -v xz; } >/dev/null; then
        apt-get install -y --no-install-recommends bzip2 xz-utils
    fi
    "$setup/fetch-source" "$1" "$new/source" "$new/apt"
}

native_enter() {
    PATH=/usr/bin:/bin:$PATH exec "$@"
}

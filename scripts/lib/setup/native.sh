# The machine as the environment: a Debian-like system with YADE and the other packages.
# No package has YADE's headers; they come from its source archive, unpacked in the cache.

native_installed() {
    [[ $(dpkg-query -W -f '${source:Version}' libyade 2>&1) == "$yade_version"-* ]] &&
        [ "$(dpkg-query -W -f '${db:Status-Status}\n' $(required_packages) 2>&1 |
            sort -u)" = installed ]
}

native_source() { echo "$cache/source-$yade_version"; }
native_yade_python() { echo /usr/lib/*/yade-double/py; }

native_ready() { [ -d "$(native_source)" ] && native_installed; }

native_possible() {
    native_installed && return
    (. "$etc/os-release" && [ "$ID $VERSION_CODENAME" = "debian trixie" ]) 2>/dev/null || return 1
    [ "$(id -u)" = 0 ] && return
    why="an administrator can install YADE's packages (apt-get install$(native_missing))"
    return 1
}

native_missing() {
    for package in $(required_packages); do
        dpkg-query -W "$package" >/dev/null 2>&1 || printf ' %s' "$package"
    done
}

native_make() {
    if ! native_installed; then
        need_space /usr 4
        stage "set-up 1/2: YADE, a compiler and Python libraries by apt-get (2 to 5 min) …"
        "$setup/install-packages" "$setup/packages" 2>&1 | record ||
            { say "the packages cannot be installed here: trying a root file system"; return 1; }
    fi
    [ -d "$(native_source)" ] && return
    stage "set-up 2/2: headers of YADE from its source archive (15 MB, up to 1 min) …"
    "$setup/fetch-source" "$new/source" "$new/apt" 2>&1 | record ||
        { say "no source archive of YADE found: trying a root file system"; return 1; }
    mv "$new/source" "$(native_source)"
}

native_enter() {
    PATH=/usr/bin:/bin:$PATH exec "$@"
}

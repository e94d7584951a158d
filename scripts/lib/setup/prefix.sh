# A YADE of the user as the environment: YADE_PREFIX is the prefix of its installation. Its headers
# come from YADE_SOURCE_DIR if it is set, else from the folder that it was built from. Nothing is
# installed; the user provides the compiler and the libraries.

prefix_yade_python() {
    local folder
    for folder in "$YADE_PREFIX"/lib/*/yade*/py "$YADE_PREFIX"/lib/yade*/py; do
        [ ! -e "$folder/yade/config.py" ] || { echo "$folder" && return; }
    done
}

# prefix_config NAME: prints a text of YADE's configuration
prefix_config() { sed -n "s/^$1='\(.*\)'/\1/p" "$(prefix_yade_python)/yade/config.py"; }

prefix_source() { echo "${YADE_SOURCE_DIR:-$(prefix_config sourceRoot)}"; }

# prefix_version: another build of YADE has another version
prefix_version() { sha256sum <"$(prefix_yade_python)/yade/config.py" | cut -c1-12; }

prefix_ready() {
    [ -n "${YADE_PREFIX:-}" ] || return 1
    export YADE_PREFIX=$(realpath -ms "$YADE_PREFIX")
    [ -n "$(prefix_yade_python)" ] ||
        fail "YADE_PREFIX = $YADE_PREFIX has no lib/yade*/py/yade; give the prefix of your YADE"
    [ -e "$(prefix_source)/core/Scene.hpp" ] ||
        fail "$(prefix_source) has no core/Scene.hpp; set YADE_SOURCE_DIR to the sources of your YADE"
}

# prefix_enter COMMAND …: `yade` is the user's, whose name may end in its version
prefix_enter() {
    local bin name
    bin=$cache/bin-$(prefix_version)
    name=$(basename "$(dirname "$(prefix_yade_python)")")
    make_cache "$bin"
    ln -sfn "$YADE_PREFIX/bin/$name" "$bin/yade"
    PATH=$bin:$PATH exec "$@"
}

# Looks for an installed YADE and its headers, needs no compiler.
#
# Defines YADE_HEADERS_FOUND; then yade_config, the installed YADE's own account of itself, and YADE_SOURCE_DIR, the unpacked
# source archive. Else YADE_HEADERS_MISSING says what is missing and what to do.
file(GLOB yade_configs /usr/lib/*/yade*/py/yade/config.py /usr/lib/yade*/py/yade/config.py)
find_path(YADE_SOURCE_DIR core/Scene.hpp PATHS ENV YADE_SOURCE_DIR /usr/src/yade NO_DEFAULT_PATH DOC "Unpacked source archive of the installed YADE")
set(YADE_HEADERS_FOUND FALSE)
if(NOT yade_configs)
	set(YADE_HEADERS_MISSING "No installed YADE found (looked for /usr/lib/*/yade*/py/yade/config.py). Install the packages yade, libyade and python3-yade, or let scripts/yade-rcr set everything up.")
elseif(NOT EXISTS "${YADE_SOURCE_DIR}/core/Scene.hpp")
	set(YADE_HEADERS_MISSING "YADE_SOURCE_DIR = '${YADE_SOURCE_DIR}' holds no YADE source (core/Scene.hpp). Unpack the source archive of the installed YADE (apt-get source --tar-only yade) and give its folder.")
else()
	list(GET yade_configs 0 yade_config)
	set(YADE_HEADERS_FOUND TRUE)
endif()

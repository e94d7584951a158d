# Finds an installed YADE and its headers without a compiler.
#
# Defines YADE_HEADERS_FOUND, yade_config, the Python file with the configuration of the installed
# YADE, and YADE_SOURCE_DIR, its unpacked source archive; or YADE_HEADERS_MISSING, an error message.
file(GLOB yade_configs /usr/lib/*/yade*/py/yade/config.py /usr/lib/yade*/py/yade/config.py)
find_path(YADE_SOURCE_DIR core/Scene.hpp PATHS ENV YADE_SOURCE_DIR /usr/src/yade NO_DEFAULT_PATH
	DOC "Unpacked source archive of the installed YADE")
set(YADE_HEADERS_FOUND FALSE)
if(NOT yade_configs)
	set(YADE_HEADERS_MISSING "No YADE found in /usr/lib/*/yade*/py/yade/config.py. Install \
the packages yade, libyade and python3-yade, or run scripts/yade-rcr, which sets everything up.")
elseif(NOT EXISTS "${YADE_SOURCE_DIR}/core/Scene.hpp")
	set(YADE_HEADERS_MISSING "YADE_SOURCE_DIR = '${YADE_SOURCE_DIR}' has no core/Scene.hpp. Unpack \
the source archive of the installed YADE (apt-get source --tar-only yade) and give its folder.")
else()
	list(GET yade_configs 0 yade_config)
	set(YADE_HEADERS_FOUND TRUE)
endif()

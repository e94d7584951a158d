# Finds an installed YADE and its headers without a compiler.
#
# Defines YADE_HEADERS_FOUND, yade_config, the Python file with the configuration of the installed
# YADE, YADE_SOURCE_DIR, its sources, yade_source_version, and yade_source_is_checkout if the sources
# are a checkout without a version; or YADE_HEADERS_MISSING, an error message.
set(yade_prefix /usr)
if(DEFINED ENV{YADE_PREFIX})
	set(yade_prefix "$ENV{YADE_PREFIX}")
endif()
set(YADE_PREFIX "${yade_prefix}" CACHE PATH "Prefix of the installed YADE")
file(GLOB yade_configs ${YADE_PREFIX}/lib/*/yade*/py/yade/config.py
	${YADE_PREFIX}/lib/yade*/py/yade/config.py)
find_path(YADE_SOURCE_DIR core/Scene.hpp PATHS ENV YADE_SOURCE_DIR /usr/src/yade NO_DEFAULT_PATH
	DOC "Sources of the installed YADE")
set(YADE_HEADERS_FOUND FALSE)
if(NOT yade_configs)
	set(YADE_HEADERS_MISSING "No YADE found in ${YADE_PREFIX}/lib/*/yade*/py/yade/config.py. Install \
the packages yade, libyade and python3-yade, give the prefix of your own YADE (-DYADE_PREFIX=FOLDER), \
or run scripts/yade-rcr, which sets everything up.")
elseif(NOT EXISTS "${YADE_SOURCE_DIR}/core/Scene.hpp")
	set(YADE_HEADERS_MISSING "YADE_SOURCE_DIR = '${YADE_SOURCE_DIR}' has no core/Scene.hpp. Unpack \
the source archive of the installed YADE (apt-get source --tar-only yade) and give its folder.")
else()
	list(GET yade_configs 0 yade_config)
	if(EXISTS "${YADE_SOURCE_DIR}/RELEASE")
		file(STRINGS "${YADE_SOURCE_DIR}/RELEASE" yade_source_version LIMIT_COUNT 1)
	else() # a checkout, which YADE's build names DATE.git-COMMIT with seven digits
		set(yade_source_is_checkout TRUE)
		execute_process(
			COMMAND git -C "${YADE_SOURCE_DIR}" log -1 --date=short --format=%ad.git-%H
			OUTPUT_VARIABLE yade_source_version)
		string(SUBSTRING "${yade_source_version}" 0 22 yade_source_version)
	endif()
	set(YADE_HEADERS_FOUND TRUE)
endif()

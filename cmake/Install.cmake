# Installation and the Debian package.
#
# The prefix sets the folder of the Python package, so it is evaluated at the installation. Debian's
# python3 and YADE search lib/python3/dist-packages under /usr and lib/python3.X/dist-packages under
# /usr/local. RCR_SITE overrides the folder. A wheel has the package at its root.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(RCR_SITE "" CACHE STRING "Folder of the Python package under the prefix; empty: that of Debian")
if(SKBUILD)
	set(RCR_PYTHON_DIR .)
elseif(RCR_SITE)
	set(RCR_PYTHON_DIR "${RCR_SITE}")
else()
	set(RCR_PYTHON_DIR "\${rcr_site}") # evaluated by the install script
	install(CODE "
		set(rcr_site \"lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/dist-packages\")
		if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
			set(rcr_site \"lib/python3/dist-packages\")
		endif()")
endif()
install(DIRECTORY py/rcr DESTINATION "${RCR_PYTHON_DIR}"
	FILES_MATCHING PATTERN "*.py" PATTERN "__pycache__" EXCLUDE)
if(SKBUILD)
	return()
endif()
install(FILES README.md CHANGELOG.md DESTINATION share/doc/yade-rcr)
install(FILES LICENSE DESTINATION share/doc/yade-rcr RENAME copyright)
install(DIRECTORY examples/ DESTINATION share/doc/yade-rcr/examples
	FILES_MATCHING PATTERN "*.py" PATTERN "*.table" PATTERN "*.ipynb")

# The Debian package: `cpack -G DEB` in the build folder. It depends on the versions of YADE and
# Python of the build.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "The authors of yade-rcr")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_STRIP_FILES TRUE)
include(${CMAKE_CURRENT_LIST_DIR}/YadeHeaders.cmake)
if(YADE_HEADERS_FOUND)
	# Jupyter's kernel "YADE": python3 with the Python modules of YADE, which lie outside its path.
	cmake_path(GET yade_config PARENT_PATH yade_package)
	cmake_path(GET yade_package PARENT_PATH rcr_yade_python)
	configure_file(${CMAKE_CURRENT_LIST_DIR}/kernel.json.in kernel.json @ONLY)
	install(FILES ${CMAKE_BINARY_DIR}/kernel.json DESTINATION share/jupyter/kernels/yade)
	file(GLOB rcr_amd /usr/lib/*/libamd.so.[0-9])
	string(REGEX REPLACE ".*\\.so\\." "libamd" rcr_amd "${rcr_amd}") # package of SuiteSparse's AMD
	math(EXPR rcr_next_python "${Python3_VERSION_MINOR} + 1")
	string(JOIN ", " CPACK_DEBIAN_PACKAGE_DEPENDS
		yade python3-yade "libyade (>= ${yade_source_version})"
		"libyade (<< ${yade_source_version}.0)"
		"python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR})"
		"python3 (<< ${Python3_VERSION_MAJOR}.${rcr_next_python})"
		${rcr_amd} libgl1 python3-numpy python3-scipy
		python3-h5py python3-matplotlib python3-tqdm)
	set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-meshio, ffmpeg, python3-ipykernel")
endif()
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
	${CMAKE_CURRENT_LIST_DIR}/postinst ${CMAKE_CURRENT_LIST_DIR}/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
include(CPack)

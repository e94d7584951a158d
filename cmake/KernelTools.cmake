# Finds what the kernels need: a C++ compiler and SuiteSparse's AMD.
#
# Defines KERNEL_TOOLS_FOUND and KERNEL_TOOLS_RESULT, a message.
set(KERNEL_TOOLS_FOUND FALSE)
include(CheckLanguage)
check_language(CXX)
if(CMAKE_CXX_COMPILER)
	enable_language(CXX) # find_library needs the folders of the compiler
	find_path(AMD_INCLUDE_DIR amd.h PATH_SUFFIXES suitesparse)
	find_library(AMD_LIBRARY amd)
	if(AMD_INCLUDE_DIR AND AMD_LIBRARY)
		set(KERNEL_TOOLS_FOUND TRUE)
	endif()
endif()
if(KERNEL_TOOLS_FOUND)
	set(KERNEL_TOOLS_RESULT "The solver is compiled without YADE.")
else()
	set(KERNEL_TOOLS_RESULT "No C++ compiler or no SuiteSparse (libsuitesparse-dev) found. Nothing is \
compiled: the package is Python only.")
endif()

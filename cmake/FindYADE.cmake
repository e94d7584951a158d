# Finds an installed YADE and the headers of the same version. The version of a checkout is unknown
# where YADE is a release: this is a warning.
#
# YADE has no development package. Its headers come from its sources in YADE_SOURCE_DIR. Class
# layouts depend on the definitions of YADE's build, which follow from the features of the installed
# YADE. An unknown feature is an error.
#
# Defines the target YADE::YADE, YADE_VERSION, and YADE_OPENGL if YADE has a 3D view.

include(${CMAKE_CURRENT_LIST_DIR}/YadeHeaders.cmake)
if(NOT YADE_HEADERS_FOUND)
	message(FATAL_ERROR "${YADE_HEADERS_MISSING}")
endif()
get_filename_component(yade_python "${yade_config}" DIRECTORY)
get_filename_component(yade_library_dir "${yade_python}/../.." ABSOLUTE)

set(yade_query "import runpy, sys; c = runpy.run_path(sys.argv[1]); print(c['version'], \
c['highPrecisionBits'], c['highPrecisionDecimalPlaces'], *c['features'], sep=';')")
execute_process(
	COMMAND "${Python3_EXECUTABLE}" -c "${yade_query}" "${yade_config}"
	OUTPUT_VARIABLE yade_facts OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
list(POP_FRONT yade_facts YADE_VERSION yade_bits yade_decimals)

if(yade_source_is_checkout AND NOT YADE_VERSION MATCHES "[.]git-")
	message(WARNING "YADE_SOURCE_DIR = ${YADE_SOURCE_DIR} is a checkout, ${yade_source_version}; the \
installed YADE is the release ${YADE_VERSION}. Another version may have classes of another layout: \
check out the tag ${YADE_VERSION}, and run the tests after the build.")
elseif(NOT yade_source_version STREQUAL YADE_VERSION)
	message(FATAL_ERROR "YADE_SOURCE_DIR = ${YADE_SOURCE_DIR} has version ${yade_source_version}, \
the installed YADE has ${YADE_VERSION}. Give the sources of version ${YADE_VERSION}.")
endif()

# Definitions of each feature for the headers (CMakeLists.txt of YADE); empty: no effect on layouts.
foreach(feature USEFUL_ERRORS REAL_HP MPC VECTORIZE CGAL) # CGAL: only in number traits
	set(yade_feature_${feature} "")
endforeach()
foreach(feature COMPLEX_MP MPFR VTK OPENMP GTS MPI LS_DEM GL2PS POTENTIAL_PARTICLES
		POTENTIAL_BLOCKS SPH DEFORM LIQMIGRATION)
	set(yade_feature_${feature} YADE_${feature})
endforeach()
foreach(feature TWOPHASEFLOW LINSOLV THERMAL PARTIALSAT)
	set(yade_feature_${feature} ${feature})
endforeach()
set(yade_feature_LOGGER YADE_BOOST_LOG BOOST_LOG_DYN_LINK MAX_LOG_LEVEL=5)
set(yade_feature_QT5 YADE_OPENGL YADE_QT5 QT_NO_KEYWORDS)
set(yade_feature_FEMLIKE YADE_FEM)
set(yade_feature_LBMFLOW LBM_ENGINE)
set(yade_feature_PFVFLOW FLOW_ENGINE)
set(yade_feature_PROFILING USE_TIMING_DELTAS ISC_TIMING)
set(yade_definitions YADE_REAL_BIT=${yade_bits} YADE_REAL_DEC=${yade_decimals})
if(NOT "VECTORIZE" IN_LIST yade_facts) # kernels share no Eigen type
	list(APPEND yade_definitions
		EIGEN_DONT_VECTORIZE EIGEN_DONT_ALIGN EIGEN_DISABLE_UNALIGNED_ARRAY_ASSERT)
	set(yade_feature_FAST_NATIVE "") # else the processor decides the alignment of Eigen's types
endif()
foreach(feature IN LISTS yade_facts)
	if(NOT DEFINED yade_feature_${feature})
		message(FATAL_ERROR "YADE ${YADE_VERSION} has the feature ${feature}, unknown to \
cmake/FindYADE.cmake. Add its definitions from YADE's CMakeLists.txt there.")
	endif()
	list(APPEND yade_definitions ${yade_feature_${feature}})
endforeach()

if("YADE_OPENGL" IN_LIST yade_definitions)
	set(YADE_OPENGL TRUE)
endif()

if(POLICY CMP0167) # use the configuration of Boost
	cmake_policy(SET CMP0167 NEW)
endif()
set(yade_python_version ${Python3_VERSION_MAJOR}${Python3_VERSION_MINOR})
find_package(Boost REQUIRED COMPONENTS python${yade_python_version} serialization log thread)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenMP REQUIRED COMPONENTS CXX)
if("MPI" IN_LIST yade_facts)
	find_package(MPI REQUIRED COMPONENTS CXX)
endif()

add_library(YADE::YADE INTERFACE IMPORTED)
target_include_directories(YADE::YADE SYSTEM INTERFACE "${YADE_SOURCE_DIR}")
target_compile_definitions(YADE::YADE INTERFACE ${yade_definitions})
target_link_directories(YADE::YADE INTERFACE "${yade_library_dir}")
target_link_options(YADE::YADE INTERFACE "-Wl,-rpath,${yade_library_dir}")
target_link_libraries(YADE::YADE INTERFACE
	yade pkg_common pkg_dem Boost::headers Boost::python${yade_python_version}
	Boost::serialization Boost::log Boost::thread Eigen3::Eigen OpenMP::OpenMP_CXX
	$<$<BOOL:${MPI_CXX_FOUND}>:MPI::MPI_CXX>)

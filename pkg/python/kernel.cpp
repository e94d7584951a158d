// Module rcr._kernel: the kernels for NumPy, without YADE. Units as in the headers of the kernels,
// angles in rad.
#include "kernel_arrays.hpp"
#include "sweep/lane/packed_blocks.hpp"

PYBIND11_MODULE(_kernel, m)
{
	m.doc()         = "Kernels of yade-rcr for NumPy: stadium, shadow overlap, contact problem.";
	m.attr("build") = RCR_BUILD;
	m.def(
	        "lanes", [] { return rcr::packedKernels(0).width; },
	        "Width of the vectors of this processor, in contact points.");
	rcr::bindGeometry(m);
	rcr::bindSolvers(m);
	rcr::bindInternals(m);
	rcr::bindThreads(m);
}

// rcr._kernel: the kernels for NumPy, without YADE. Angles in rad, everything else as in the kernels' headers.
#include "kernel_arrays.hpp"
#include "sweep/lane/packed_blocks.hpp"

PYBIND11_MODULE(_kernel, m)
{
	m.doc() = "Kernels of yade-rcr for NumPy: stadium, shadow overlap, contact problem. They need no YADE.";
	m.attr("build") = RCR_BUILD;
	m.def("lanes", [] { return rcr::packedKernels(0).width; }, "Contact points that the sweeps of this processor take at a time.");
	rcr::bindGeometry(m);
	rcr::bindSolvers(m);
	rcr::bindInternals(m);
	rcr::bindThreads(m);
}

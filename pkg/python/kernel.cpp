// Module rcr._kernel: the kernels for NumPy, without YADE. Units as in the headers of the kernels,
// angles in rad.
#include "kernel_arrays.hpp"

PYBIND11_MODULE(_kernel, m)
{
	m.doc()         = "Kernels of yade-rcr for NumPy: stadium, shadow overlap, contact problem.";
	m.attr("build") = RCR_BUILD;
	rcr::bindGeometry(m);
	rcr::bindSolvers(m);
	rcr::bindSteps(m);
	rcr::bindInternals(m);
	rcr::bindStateMachines(m);
	rcr::bindThreads(m);
}

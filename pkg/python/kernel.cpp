// rcr._kernel: the kernels for NumPy, without YADE. Angles in rad, everything else as in the kernels' headers.
#include "kernel_arrays.hpp"

PYBIND11_MODULE(_kernel, m)
{
	m.doc() = "Kernels of yade-rcr for NumPy: stadium, shadow overlap, contact problem. They need no YADE.";
	rcr::bindGeometry(m);
	rcr::bindSolvers(m);
	rcr::bindInternals(m);
}

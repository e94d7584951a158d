// What the bindings of the kernels share: arrays in and out, their checks, and the parts of the module.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chrono>
#include <cstdint>
#include <ctime>
#include <string>
#include <vector>

#include "delassus/delassus_problem.hpp"
#include "problem/contact_problem.hpp"

namespace rcr {

namespace py = pybind11;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids   = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// Throws ValueError with the shape given and the one wanted; `columns` = 1 wants one dimension.
void wantShape(const py::array&, const char* name, py::ssize_t rows, py::ssize_t columns);
void wantBlocks(const py::array&, const char* name, py::ssize_t count); // (count, 3, 3)

/// Ids as they were given: throws ValueError for numbers that are not integers or do not fit into 32 bits.
Ids wholeIds(const py::object&, const char* name);

/// Arrays of a problem that most have not, or None: d (nc, 2), s (nc, 2), M_c⁻¹ (2,) and recovery (nc,).
struct OptionalArrays {
	py::object drift = py::none(), shift = py::none(), inverseStretchMass = py::none(), recovery = py::none();
};

/// A problem from arrays; every array is checked, and no id or number can be out of range.
ContactProblem problemFrom(
        const Array& inverseMass, const Array& freeVelocity, const py::object& bodies, const Array& normal, const Array& arm1, const Array& arm2,
        const Array& bias, const Array& friction, const Array& impulse, const OptionalArrays& = {});

/// Arrays of the right shapes; what they hold is checked by the solver.
DelassusProblem delassusFrom(
        const py::object& rowStart, const py::object& column, const Array& block, const Array& free, const Array& friction, const Array& impulse);

inline py::ssize_t rowsOf(const py::array& array) { return array.ndim() ? array.shape(0) : 0; }

Array arrayOf(const std::vector<Impulse>&); // (n, 2)
Array arrayOf(const std::vector<Twist>&);   // (n, 3)

/// Time since it was made [s]: by the clock, and of the processor on this thread, which other programs do not lengthen.
class Stopwatch {
public:
	double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
	double processorSeconds() const { return processorNow() - processorStart_; }

private:
	using Clock = std::chrono::steady_clock;

	static double processorNow()
	{
		timespec now;
		clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
		return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
	}

	Clock::time_point start_          = Clock::now();
	double            processorStart_ = processorNow();
};

// The parts of the module.
void bindGeometry(py::module_&);
void bindSolvers(py::module_&);
void bindInternals(py::module_&);
void bindThreads(py::module_&);

} // namespace rcr

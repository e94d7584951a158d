// Arrays in and out of the bindings, with checks; and the parts of the module.
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
#include "problem/solver.hpp"

namespace rcr {

namespace py = pybind11;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids   = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// Throws ValueError if the shape is not (rows, columns), or (rows,) for columns = 1.
void requireShape(const py::array&, const char* name, py::ssize_t rows, py::ssize_t columns);
void requireBlocks(const py::array&, const char* name, py::ssize_t count); // shape (count, 3, 3)

/// Ids from an array of integers. Throws ValueError for other types and for more than 32 bits.
Ids idsFrom(const py::object&, const char* name);

/// Optional arrays of a problem, or None: d (nc, 2), s (nc, 2), M_c⁻¹ (2,) and recovery (nc,).
struct OptionalArrays {
	py::object drift = py::none(), shift = py::none(), inverseStretchMass = py::none(),
	           recovery = py::none();
};

/// A problem from arrays. Checks all shapes, ids and numbers.
ContactProblem problemFrom(
        const Array& inverseMass, const Array& freeVelocity, const py::object& bodies,
        const Array& normal, const Array& arm1, const Array& arm2, const Array& bias,
        const Array& friction, const Array& impulse, const OptionalArrays& = {});

/// A problem of W and q from arrays. Checks the shapes; the solver checks the values.
DelassusProblem delassusFrom(
        const py::object& rowStart, const py::object& column, const Array& block, const Array& free,
        const Array& friction, const Array& impulse);

/// Default settings except those of the stop test (sweep/stop_test.hpp).
Settings stopSettings(
        double tolerance, double kinematicTolerance, double meanForceChange, int checkInterval,
        int minIterations, int maxIterations, int stallSweeps);

inline py::ssize_t rowsOf(const py::array& array) { return array.ndim() ? array.shape(0) : 0; }

Array arrayOf(const std::vector<Impulse>&); // (n, 2)
Array arrayOf(const std::vector<Twist>&);   // (n, 3)

/// Wall time and processor time of this thread since construction [s].
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
void bindDetectors(py::module_&);
void bindThreads(py::module_&);

} // namespace rcr

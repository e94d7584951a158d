// Arrays in and out of the bindings, with checks; and the parts of the module.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>
#include <initializer_list>

#include "solve/solve.hpp"

namespace rcr {

namespace py = pybind11;
using namespace py::literals;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids   = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// Throws ValueError for another shape.
void requireShape(const py::array&, const char* name, std::initializer_list<py::ssize_t> shape);

/// Ids from an array of integers. Throws ValueError for other types and for more than 32 bits.
Ids idsFrom(const py::object&, const char* name);

/// A problem from the arrays of `solve`, by name. Checks all names, shapes, ids and numbers.
ContactProblem problemFrom(const py::kwargs& arrays);

/// Default settings except those of the stop test (sweep/stop_test.hpp).
Settings stopSettings(double tolerance, double accuracy, double meanForceChange,
        int checkInterval, int minIterations, int maxIterations, int stallSweeps);

inline py::ssize_t rowsOf(const py::array& array) { return array.ndim() ? array.shape(0) : 0; }

/// Rows of an array as structs of doubles. Throws ValueError for another shape.
template <class Row>
std::vector<Row> rowsFrom(const Array& array, const char* name, py::ssize_t count)
{
	constexpr py::ssize_t columns = sizeof(Row) / sizeof(double);
	if (columns > 1)
		requireShape(array, name, { count, columns });
	else
		requireShape(array, name, { count });
	std::vector<Row> rows(count);
	if (count > 0) std::memcpy(static_cast<void*>(rows.data()), array.data(), count * sizeof(Row));
	return rows;
}

/// Array of these rows, as rowsFrom reads it.
template <class Row> Array arrayOf(const std::vector<Row>& rows)
{
	Array array({ py::ssize_t(rows.size()), py::ssize_t(sizeof(Row) / sizeof(double)) });
	if (!rows.empty()) std::memcpy(array.mutable_data(), rows.data(), rows.size() * sizeof(Row));
	return array;
}

// The parts of the module.
void bindGeometry(py::module_&);
void bindSolvers(py::module_&);
void bindSteps(py::module_&);
void bindInternals(py::module_&);
void bindStateMachines(py::module_&);
void bindThreads(py::module_&);

} // namespace rcr

#include "kernel_arrays.hpp"

#include <limits>
#include <sstream>

#include "parallel/thread_team.hpp"

namespace rcr {

namespace {

	[[noreturn]] void refuseShape(
	        const py::array& array, const char* name, const std::string& expected)
	{
		std::ostringstream message;
		message << name << " has shape (";
		for (py::ssize_t k = 0; k < array.ndim(); ++k)
			message << (k ? ", " : "") << array.shape(k);
		throw py::value_error(message.str() + "); expected (" + expected + ")");
	}

} // namespace

void requireShape(const py::array& array, const char* name, py::ssize_t rows, py::ssize_t columns)
{
	const bool fits = columns == 1
	        ? array.ndim() == 1 && array.shape(0) == rows
	        : array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns;
	if (!fits)
		refuseShape(
		        array, name,
		        std::to_string(rows) + (columns > 1 ? ", " + std::to_string(columns) : ""));
}

void requireBlocks(const py::array& array, const char* name, py::ssize_t count)
{
	if (array.ndim() != 3 || array.shape(0) != count || array.shape(1) != 3 || array.shape(2) != 3)
		refuseShape(array, name, std::to_string(count) + ", 3, 3");
}

Ids idsFrom(const py::object& given, const char* name)
{
	const py::array array = py::array::ensure(given);
	if (!array) throw py::error_already_set();
	const char kind = array.dtype().kind();
	if (array.size() > 0 && kind != 'i' && kind != 'u')
		throw py::value_error(
		        std::string(name) + " holds " + std::string(py::str(array.dtype()))
		        + "; expected integers");
	const auto wide
	        = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
	for (py::ssize_t k = 0; k < wide.size(); ++k) {
		const std::int64_t id = wide.data()[k];
		if (id < std::numeric_limits<std::int32_t>::min()
		    || id > std::numeric_limits<std::int32_t>::max()) {
			std::ostringstream message;
			message << name << " holds " << id << "; expected integers of 32 bits";
			throw py::value_error(message.str());
		}
	}
	return Ids::ensure(array);
}

ContactProblem problemFrom(
        const Array& inverseMass, const Array& freeVelocity, const py::object& givenBodies,
        const Array& normal, const Array& arm1, const Array& arm2, const Array& bias,
        const Array& friction, const Array& impulse, const OptionalArrays& optional)
{
	const Ids         bodies = idsFrom(givenBodies, "bodies");
	const py::ssize_t nb = rowsOf(inverseMass), nc = rowsOf(bodies);
	requireShape(inverseMass, "inverse_mass", nb, 3);
	requireShape(freeVelocity, "free_velocity", nb, 3);
	requireShape(bodies, "bodies", nc, 2);
	requireShape(normal, "normal", nc, 2);
	requireShape(arm1, "arm1", nc, 2);
	requireShape(arm2, "arm2", nc, 2);
	requireShape(bias, "bias", nc, 1);
	requireShape(friction, "friction", nc, 1);
	requireShape(impulse, "impulse", nc, 2);
	const auto vectors = [nc](const py::object& given, const char* name) {
		if (given.is_none()) return std::vector<Vec2>(nc);
		const Array array = given.cast<Array>();
		requireShape(array, name, nc, 2);
		std::vector<Vec2> values;
		for (py::ssize_t k = 0; k < nc; ++k)
			values.push_back({ array.at(k, 0), array.at(k, 1) });
		return values;
	};
	const std::vector<Vec2> drift = vectors(optional.drift, "drift"),
	                        shift = vectors(optional.shift, "shift");

	ContactProblem problem;
	for (py::ssize_t i = 0; i < nb; ++i) {
		problem.inverseMass.push_back(
		        { inverseMass.at(i, 0), inverseMass.at(i, 1), inverseMass.at(i, 2) });
		problem.freeVelocity.push_back(
		        { freeVelocity.at(i, 0), freeVelocity.at(i, 1), freeVelocity.at(i, 2) });
	}
	for (py::ssize_t k = 0; k < nc; ++k) {
		const auto vec = [k](const Array& a) { return Vec2 { a.at(k, 0), a.at(k, 1) }; };
		problem.points.push_back({ bodies.at(k, 0), bodies.at(k, 1), vec(normal), vec(arm1),
		                           vec(arm2), bias.at(k), friction.at(k), drift[k], shift[k] });
		problem.impulse.push_back({ impulse.at(k, 0), impulse.at(k, 1) });
	}
	if (!optional.inverseStretchMass.is_none()) {
		const Array mass = optional.inverseStretchMass.cast<Array>();
		requireShape(mass, "inverse_stretch_mass", 2, 1);
		problem.inverseStretchMass = { mass.at(0), mass.at(1) };
	}
	if (!optional.recovery.is_none()) {
		const Array recovery = optional.recovery.cast<Array>();
		requireShape(recovery, "recovery", nc, 1);
		problem.recovery.assign(recovery.data(), recovery.data() + nc);
	}
	ThreadTeam team;
	checkProblem(problem, team);
	return problem;
}

DelassusProblem delassusFrom(
        const py::object& givenRowStart, const py::object& givenColumn, const Array& block,
        const Array& free, const Array& friction, const Array& impulse)
{
	const Ids rowStart   = idsFrom(givenRowStart, "row_start"),
	          column     = idsFrom(givenColumn, "column");
	const py::ssize_t nc = rowsOf(free), entries = rowsOf(column);
	requireShape(free, "free", nc, 2);
	requireShape(friction, "friction", nc, 1);
	requireShape(impulse, "impulse", nc, 2);
	requireShape(rowStart, "row_start", nc + 1, 1);
	requireShape(column, "column", entries, 1);
	requireShape(block, "block", entries, 4);
	DelassusProblem problem;
	problem.rowStart.assign(rowStart.data(), rowStart.data() + nc + 1);
	problem.column.assign(column.data(), column.data() + entries);
	for (py::ssize_t e = 0; e < entries; ++e)
		problem.block.push_back({ block.at(e, 0), block.at(e, 1), block.at(e, 2), block.at(e, 3) });
	for (py::ssize_t k = 0; k < nc; ++k) {
		problem.free.push_back({ free.at(k, 0), free.at(k, 1) });
		problem.friction.push_back(friction.at(k));
		problem.impulse.push_back({ impulse.at(k, 0), impulse.at(k, 1) });
	}
	return problem;
}

Settings stopSettings(
        double tolerance, double kinematicTolerance, double meanForceChange, int checkInterval,
        int minIterations, int maxIterations, int stallSweeps)
{
	Settings settings;
	settings.tolerance          = tolerance;
	settings.kinematicTolerance = kinematicTolerance;
	settings.meanForceChange    = meanForceChange;
	settings.checkInterval      = checkInterval;
	settings.minIterations      = minIterations;
	settings.maxIterations      = maxIterations;
	settings.stallSweeps        = stallSweeps;
	return settings;
}

Array arrayOf(const std::vector<Impulse>& values)
{
	Array result({ py::ssize_t(values.size()), py::ssize_t(2) });
	for (std::size_t k = 0; k < values.size(); ++k)
		result.mutable_at(k, 0) = values[k].n, result.mutable_at(k, 1) = values[k].t;
	return result;
}

Array arrayOf(const std::vector<Twist>& values)
{
	Array result({ py::ssize_t(values.size()), py::ssize_t(3) });
	for (std::size_t k = 0; k < values.size(); ++k) {
		result.mutable_at(k, 0) = values[k].x;
		result.mutable_at(k, 1) = values[k].y;
		result.mutable_at(k, 2) = values[k].rotation;
	}
	return result;
}

} // namespace rcr

#include "kernel_arrays.hpp"

#include <set>

#include "parallel/thread_team.hpp"
#include "problem/refuse.hpp"

namespace rcr {

void requireShape(
        const py::array& array, const char* name, std::initializer_list<py::ssize_t> shape)
{
	const py::ssize_t* given = array.shape();
	if (std::equal(given, given + array.ndim(), shape.begin(), shape.end())) return;
	const auto listed = [](const py::ssize_t* sizes, py::ssize_t count) {
		std::string list;
		for (py::ssize_t k = 0; k < count; ++k)
			list += (k ? ", " : "") + std::to_string(sizes[k]);
		return '(' + list + ')';
	};
	refuse(name, " has shape ", listed(given, array.ndim()), "; expected ",
	        listed(shape.begin(), shape.size()));
}

Ids idsFrom(const py::object& given, const char* name)
{
	const py::array array = py::array::ensure(given);
	if (!array) throw py::error_already_set();
	const char kind = array.dtype().kind();
	if (array.size() > 0 && kind != 'i' && kind != 'u')
		refuse(name, " holds ", std::string(py::str(array.dtype())), "; expected integers");
	const auto wide
	        = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
	for (py::ssize_t k = 0; k < wide.size(); ++k) {
		const std::int64_t id = wide.data()[k];
		if (id != std::int32_t(id)) refuse(name, " holds ", id, "; expected integers of 32 bits");
	}
	return Ids::ensure(array);
}

ContactProblem problemFrom(const py::kwargs& arrays)
{
	static const std::set<std::string> names { "inverse_mass", "free_velocity", "bodies", "normal",
		"arm1", "arm2", "bias", "friction", "impulse", "drift", "shift", "inverse_stretch_mass",
		"place", "recovery_bias", "yielded", "pull", "rolling_friction", "rolling_length",
		"rolling_impulse" };
	for (const auto& item : arrays)
		if (const std::string name = py::str(item.first); !names.count(name))
			throw py::type_error("'" + name + "' is neither a setting nor an array of a problem");
	const auto given = [&](const char* name) { return arrays[name].cast<Array>(); };
	const auto has
	        = [&](const char* name) { return arrays.contains(name) && !arrays[name].is_none(); };
	const Array       inverseMass = given("inverse_mass");
	const Ids         bodies      = idsFrom(arrays["bodies"], "bodies");
	const py::ssize_t nb = rowsOf(inverseMass), nc = rowsOf(bodies);
	requireShape(bodies, "bodies", { nc, 2 });
	const auto vectors = [&](const char* name) { return rowsFrom<Vec2>(given(name), name, nc); };
	const auto numbers = [&](const char* name) { return rowsFrom<double>(given(name), name, nc); };
	const auto optional
	        = [&](const char* name) { return has(name) ? vectors(name) : std::vector<Vec2>(nc); };
	const auto normal = vectors("normal"), arm1 = vectors("arm1"), arm2 = vectors("arm2"),
	           drift = optional("drift"), shift = optional("shift");
	const auto bias = numbers("bias"), friction = numbers("friction");
	const auto optionalNumbers = [&](const char* name) {
		return has(name) ? numbers(name) : std::vector<double>(nc);
	};
	const auto pull = optionalNumbers("pull"), rollingFriction = optionalNumbers("rolling_friction"),
	           rollingLength = optionalNumbers("rolling_length");

	ContactProblem problem;
	problem.inverseMass  = rowsFrom<InverseMass>(inverseMass, "inverse_mass", nb);
	problem.freeVelocity = rowsFrom<PlanarVector>(given("free_velocity"), "free_velocity", nb);
	problem.impulse      = rowsFrom<LocalVector>(given("impulse"), "impulse", nc);
	for (py::ssize_t k = 0; k < nc; ++k)
		problem.points.push_back({ bodies.at(k, 0), bodies.at(k, 1), normal[k], arm1[k], arm2[k],
		                           bias[k], friction[k], drift[k], shift[k], pull[k],
		                           rollingFriction[k], rollingLength[k] });
	if (has("rolling_friction")) problem.rollingImpulse = optionalNumbers("rolling_impulse");
	if (has("inverse_stretch_mass")) {
		const Array mass = given("inverse_stretch_mass");
		requireShape(mass, "inverse_stretch_mass", { 2 });
		problem.inverseStretchMass = { mass.at(0), mass.at(1) };
	}
	if (has("place")) problem.place = rowsFrom<Vec2>(given("place"), "place", nb);
	if (has("recovery_bias")) problem.recoveryBias = numbers("recovery_bias");
	if (has("yielded"))
		for (double one : rowsFrom<double>(given("yielded"), "yielded", nb))
			problem.yielded.push_back(one != 0);
	ThreadTeam team;
	checkProblem(problem, team);
	return problem;
}

Settings stopSettings(double tolerance, double accuracy, double meanForceChange,
        int checkInterval, int minIterations, int maxIterations, int stallSweeps)
{
	Settings settings;
	settings.tolerance          = tolerance;
	settings.accuracy           = accuracy;
	settings.meanForceChange    = meanForceChange;
	settings.checkInterval      = checkInterval;
	settings.minIterations      = minIterations;
	settings.maxIterations      = maxIterations;
	settings.stallSweeps        = stallSweeps;
	return settings;
}

} // namespace rcr

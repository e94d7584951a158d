// What ContactDynamics tells Python.
#include <array>

#include "ContactDynamics.hpp"

namespace yade {

boost::python::dict ContactDynamics::secondsDict() const
{
	boost::python::dict seconds;
	for (const auto& [what, total] : seconds_)
		seconds[what] = total;
	return seconds;
}

boost::python::dict ContactDynamics::problemDict() const
{
	namespace py = boost::python;
	py::dict   columns;
	const auto add = [&](const char* name, const auto& rows) {
		const char* bytes = reinterpret_cast<const char*>(rows.data());
		columns[name]     = py::object(py::handle<>(PyBytes_FromStringAndSize(bytes, Py_ssize_t(rows.size() * sizeof(rows[0])))));
	};
	std::vector<std::array<double, 8>> points; // normal, arm1, arm2, bias, friction
	std::vector<std::array<int, 2>>    bodies;
	for (const rcr::ContactPoint& c : step_.problem.points) {
		points.push_back({ c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias, c.friction });
		bodies.push_back({ c.body1, c.body2 });
	}
	add("points", points), add("bodies", bodies), add("impulse", warmStart_);
	add("inverse_mass", step_.problem.inverseMass), add("free_velocity", step_.problem.freeVelocity);
	return columns;
}

boost::python::dict ContactDynamics::modelDict() const
{
	const rcr::ModelSummary m = workspace_.summary();
	boost::python::dict     model;
	model["bodies"]       = m.bodies;
	model["rotations"]    = m.turning;
	model["fixed"]        = m.fixed;
	model["pairs"]        = m.pairs;
	model["points"]       = m.points;
	model["unknowns"]     = m.unknowns();
	model["frictionless"] = m.frictionalPoints == 0;
	model["islands"]      = m.islands;
	model["layouts"]      = m.layouts;
	model["work"]         = work_;
	return model;
}

} // namespace yade

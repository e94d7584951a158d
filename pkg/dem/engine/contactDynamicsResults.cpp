// Counts and records steps of ContactDynamics. Returns its results as Python dicts.
#include <array>

#include "dem/engine/ContactDynamics.hpp"
#include "dem/records/StepEnd.hpp"

namespace yade {

namespace py = boost::python;

StepOutcome ContactDynamics::stepOutcome() const
{
	const bool missed = tolerance > 0 && !converged;
	return { scene->iter, double(scene->time + scene->dt), iterations, contactPoints,
		double(residual), missed, yielded,
		missed ? std::min(double(errorEstimate), 1.0) : 0 };
}

/// Counts the step with its overlap at the beginning. Throws the error of a jam.
void ContactDynamics::monitorStep()
{
	const std::lock_guard<std::mutex> lock(attributesMutex_);
	const std::string warning = monitor.count(step_, stepOutcome(), workspace_.team());
	if (!warning.empty()) LOG_WARN(warning);
}

py::dict ContactDynamics::stepCounts() const
{
	const StepMonitor now = get<&ContactDynamics::monitor>();
	py::dict          counts;
	counts["steps"]         = now.steps.steps;
	counts["missed"]        = now.steps.missed;
	counts["yielded"]       = now.steps.yielded;
	counts["deepest"]       = now.steps.deepest;
	counts["largest_error"] = now.largestError;
	return counts;
}

std::string ContactDynamics::changeSinceStep() const
{
	// after O.load, Engine::scene is that of before until the first step
	const Scene& now = *Omega::instance().getScene();
	return validator_.hasSolved(now) ? changeSince(now, step_.dt, step_.problem.velocity)
	                                 : std::string();
}

py::dict ContactDynamics::problemDict() const
{
	if (Omega::instance().isRunning() && stepThread_.load() != std::this_thread::get_id())
		throw std::runtime_error(
		        "ContactDynamics: the contact problem changes during O.run; call O.pause() first.");
	py::dict   columns;
	const auto add = [&](const char* name, const auto& rows) {
		const char* bytes = reinterpret_cast<const char*>(rows.data());
		columns[name]     = py::object(py::handle<>(
                PyBytes_FromStringAndSize(bytes, Py_ssize_t(rows.size() * sizeof(rows[0])))));
	};
	// normal, arm1, arm2, bias, friction, pull, rolling friction, rolling length, rolling impulse
	std::vector<std::array<double, 12>> points;
	std::vector<std::array<int, 2>>     bodies;
	for (const rcr::ContactPoint& c : step_.problem.points) {
		if (c.drift.x != 0 || c.drift.y != 0 || step_.problem.stretches())
			throw std::invalid_argument(
			        "ContactDynamics: the periodic cell deforms, and files of problems have no "
			        "velocities of images; save a step at O.cell.velGrad = 0 without CellStress.");
		const std::size_t k = points.size();
		points.push_back({ c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias,
		        c.friction, c.pull, c.rollingFriction, c.rollingLength,
		        k < step_.warmRolling.size() ? step_.warmRolling[k] : 0 });
		bodies.push_back({ c.body1, c.body2 });
	}
	add("points", points), add("bodies", bodies), add("impulse", step_.warmStart);
	add("inverse_mass", step_.problem.inverseMass);
	add("free_velocity", step_.problem.freeVelocity);
	return columns;
}

} // namespace yade

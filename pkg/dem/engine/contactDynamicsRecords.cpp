// Counts and records the steps of ContactDynamics.
#include "dem/engine/ContactDynamics.hpp"

namespace yade {

/// Counts the step with its overlap at the beginning. Throws the error of a jam.
void ContactDynamics::countStep()
{
	const double                      overlap = deepestOverlap(step_, workspace_.team());
	const std::lock_guard<std::mutex> lock(reading_);
	const std::string                 warning = monitor.count(step_,
	        { scene->iter, hasMissed(), yielded, overdamped, iterations, overlap });
	if (!warning.empty()) LOG_WARN(warning);
}

void ContactDynamics::record(const std::vector<rcr::Twist>& impulses)
{
	const std::vector<int> ids = get<&ContactDynamics::observe>();
	StepObserver::check(ids, step_, handles_);
	const double toleranceRatio = hasMissed()
	        ? double(std::max(residual / tolerance, kinematicError / kinematicTolerance))
	        : 0;
	observer_.record({ scene->iter + 1, double(scene->time + scene->dt), iterations, contactPoints,
	                         double(residual), hasMissed(), yielded, toleranceRatio },
	        ids, observeEvery, impulses, step_, handles_);
	model_.setProblem(workspace_.summary(), work_, meanStretchRate);
}

} // namespace yade

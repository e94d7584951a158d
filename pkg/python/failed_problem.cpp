#include "dem/records/StepMonitor.hpp"

#include "dem/validation/validation.hpp"

namespace yade {

std::string failureMessage(const rcr::Step& step, int id, long iteration)
{
	const gilLock     lock;
	const std::string saved = boost::python::extract<std::string>(
	        boost::python::import("rcr.scene").attr("save_not_finite")());
	const rcr::Twist& v = step.problem.velocity[id];
	return "ContactDynamics: step " + std::to_string(iteration) + " would give "
	        + validation::bodyNames({ id }) + " the velocity (" + validation::text(v.x) + ", "
	        + validation::text(v.y) + ") and the angular velocity " + validation::text(v.rotation)
	        + ". Nothing has moved. " + saved;
}

} // namespace yade

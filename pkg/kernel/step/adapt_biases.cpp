#include "step/adapt_biases.hpp"

#include <algorithm>

#include "step/large_displacements.hpp"
#include "step/restitution.hpp"

namespace rcr {

bool restIsAllowed(const Step& step, const Drive& drive)
{
	const std::vector<ContactPoint>& points = step.problem.points;
	return drive.speed == 0 && std::all_of(points.begin(), points.end(), [](const ContactPoint& point) { return point.bias >= 0; });
}

bool adaptBiases(Step& step, bool letGo, bool last, double& overlap)
{
	bool changed = false, bounces = false;
	overlap      = 0;
	for (const StepContact& contact : step.contacts) {
		if (displacesFar(step, contact)) changed |= adaptToDisplacement(step, contact, letGo, overlap);
		if (contact.restitution > 0) changed |= restrainBounce(step, contact);
		bounces |= contact.restitution > 0;
	}
	if (bounces && (last || !changed)) changed |= restrainCollisions(step, last);
	return changed;
}

bool goBack(Step& step, std::vector<double>& before)
{
	if (before.empty()) return false;
	for (std::size_t k = 0; k < before.size(); ++k)
		step.problem.points[k].bias = before[k];
	before.clear();
	return true;
}

} // namespace rcr

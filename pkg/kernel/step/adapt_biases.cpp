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

bool adaptBiases(Step& step, bool letGo, bool last, double& overlap, ThreadTeam& team)
{
	struct Look {
		bool   changed, bounces;
		double overlap;
	};
	std::vector<Look> look(step.contacts.size());
	team.forEach(look.size(), [&](std::size_t k) {
		const StepContact& contact = step.contacts[k];
		look[k]                    = { false, contact.restitution > 0, 0 };
		if (displacesFar(step, contact)) look[k].changed = adaptToDisplacement(step, contact, letGo, look[k].overlap);
	});
	bool changed = false, bounces = false;
	overlap      = 0;
	for (std::size_t k = 0; k < look.size(); ++k) {
		changed |= look[k].changed;
		overlap = std::max(overlap, look[k].overlap);
		if (look[k].bounces) changed |= (letGo && takeBackBounces(step, step.contacts[k])) || restrainBounce(step, step.contacts[k]);
		bounces |= look[k].bounces;
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

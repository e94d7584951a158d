#include "step/adapt_biases.hpp"

#include <algorithm>

#include "step/large_displacements.hpp"
#include "step/restitution.hpp"

namespace rcr {

bool restIsSolution(const Step& step, const DrivenMotion& drive)
{
	const std::vector<ContactPoint>& points = step.problem.points;
	return drive.speed == 0
	        && std::all_of(points.begin(), points.end(),
	                [](const ContactPoint& point) { return point.bias >= 0; });
}

bool adaptBiases(Step& step, bool allowRelease, bool last, double& overlap, ThreadTeam& team)
{
	struct Change {
		bool   changed, bounces;
		double overlap;
	};
	std::vector<Change> change(step.contacts.size());
	team.forEach(change.size(), [&](std::size_t k) {
		const StepContact& contact = step.contacts[k];
		change[k]                    = { false, contact.restitution > 0, -1 };
		if (!displacesFar(step, contact)) return;
		change[k].overlap = 0;
		change[k].changed = adaptToDisplacement(step, contact, allowRelease, change[k].overlap);
	});
	bool changed = false, bounces = false;
	overlap      = -1;
	for (std::size_t k = 0; k < change.size(); ++k) {
		changed |= change[k].changed;
		overlap = std::max(overlap, change[k].overlap);
		if (change[k].bounces)
			changed |= (allowRelease && cancelBounces(step, step.contacts[k]))
			        || restrainBounce(step, step.contacts[k]);
		bounces |= change[k].bounces;
	}
	if (bounces && (last || !changed)) changed |= restrainCollisions(step, last);
	return changed;
}

bool restoreBiases(Step& step, std::vector<double>& before)
{
	if (before.empty()) return false;
	for (std::size_t k = 0; k < before.size(); ++k)
		step.problem.points[k].bias = before[k];
	before.clear();
	return true;
}

} // namespace rcr

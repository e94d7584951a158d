#include "step/adapt_biases.hpp"

#include "correction/large_displacements.hpp"
#include "parallel/thread_team.hpp"
#include "step/restitution.hpp"

namespace rcr {

bool restIsAdmissible(const Step& step, double driveSpeed)
{
	const auto& points = step.problem.points;
	const auto  rests  = [](const ContactPoint& point) { return point.bias >= 0; };
	return driveSpeed == 0 && std::all_of(points.begin(), points.end(), rests);
}

bool adaptBiases(Step& step, bool allowRelease, bool nextIsLast, double tolerance,
        bool& largeDisplacements, ThreadTeam& team)
{
	struct Change {
		bool isLarge, changed, pushes;
	};
	std::vector<Change> change(step.contacts.size());
	team.forEach(change.size(), [&](std::size_t k) {
		const StepContact& contact = step.contacts[k];
		if (contact.count == 0) return;
		change[k] = { hasLargeDisplacement(step, contact), false, contact.restitution > 0 };
		if (!change[k].isLarge) return;
		// no later pass would check the energy of a new push
		if (!nextIsLast) change[k].changed = adaptToDisplacement(step, contact, allowRelease);
		for (int point = contact.first; point < contact.first + contact.count; ++point)
			change[k].pushes |= step.problem.points[point].bias < 0;
	});
	bool changed = false, pushes = false;
	largeDisplacements = false;
	for (std::size_t k = 0; k < change.size(); ++k) {
		largeDisplacements |= change[k].isLarge;
		changed |= change[k].changed, pushes |= change[k].pushes;
		if (allowRelease && step.contacts[k].count > 0 && step.contacts[k].restitution > 0)
			changed |= releaseNearMiss(step, step.contacts[k]);
	}
	if (pushes) changed |= lowerPairRestitution(step);
	if (pushes && (nextIsLast || !changed))
		changed |= lowerCollisionRestitution(step, nextIsLast, tolerance);
	return changed;
}

} // namespace rcr

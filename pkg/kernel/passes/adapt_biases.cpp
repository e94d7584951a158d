#include "passes/adapt_biases.hpp"

#include "detection/large_displacements.hpp"
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
		const bool hasRestitution = contact.law.restitution > 0;
		change[k] = { hasLargeDisplacement(step, contact), false, hasRestitution };
		// no later pass would check the energy of a new push
		if (change[k].isLarge && !nextIsLast)
			change[k].changed = adaptToDisplacement(step, contact, allowRelease);
		if (hasRestitution && allowRelease) change[k].changed |= releaseNearMiss(step, contact);
		if (!change[k].isLarge) return;
		for (int point = contact.first; point < contact.first + contact.count; ++point)
			change[k].pushes |= step.problem.points[point].bias < 0;
	});
	bool changed = false, pushes = false;
	largeDisplacements = false;
	for (const Change& c : change)
		largeDisplacements |= c.isLarge, changed |= c.changed, pushes |= c.pushes;
	if (pushes) changed |= lowerPairRestitution(step);
	if (pushes && (nextIsLast || !changed))
		changed |= lowerCollisionRestitution(step, nextIsLast, tolerance);
	return changed;
}

} // namespace rcr

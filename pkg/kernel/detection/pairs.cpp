#include "detection/pairs.hpp"

#include "step/carry_forward.hpp"

namespace rcr {

/// Replaces the pairs by those of the list; known pairs keep their data. `keepContacts`: contacts
/// that the list lacks remain.
void Pairs::assign(const Neighbors::List& list, bool keepContacts)
{
	Pairs now;
	now.all.reserve(list.size()), now.manifold.reserve(list.size());
	std::size_t old  = 0;
	const auto  keep = [&](std::size_t k) {
        now.all.push_back(all[k]), now.manifold.push_back(manifold[k]);
	};
	for (const auto& [one, two] : list) {
		Pair pair;
		pair.body1 = one, pair.body2 = two;
		for (; old < all.size() && precedes(all[old], pair); ++old)
			if (keepContacts && all[old].pointCount > 0) keep(old);
		if (old < all.size() && !precedes(pair, all[old]))
			keep(old++);
		else
			now.all.push_back(pair), now.manifold.emplace_back();
	}
	for (; keepContacts && old < all.size(); ++old)
		if (all[old].pointCount > 0) keep(old);
	all.swap(now.all), manifold.swap(now.manifold);
}

void Pairs::detect(
        Search search, const Step& step, const NewContacts& host, long iteration, bool keepContacts)
{
	const bool changed = search.neighbors.update(step, search.team);
	if (changed || !listed) assign(search.neighbors.list(), keepContacts);
	listed = true;
	detectPoints(step, search.team, keepContacts);
	for (Pair& pair : all) {
		if (!pair.isNew) continue;
		if (host.allows(pair.body1, pair.body2)) {
			pair.law      = host.law(pair.body1, pair.body2);
			pair.formedAt = iteration;
		} else
			pair.pointCount = 0;
	}
}

void Pairs::store(Step& step, ThreadTeam& team, long iteration)
{
	addFoundContacts(step, iteration);
	if (!listed || !step.added.empty()) numberContacts(step);
	team.forEach(step.contacts.size(), [&](std::size_t k) {
		const StepContact& contact = step.contacts[k];
		Pair&              pair    = all[contact.handleIndex];
		std::copy_n(&step.force[contact.first], contact.count, pair.force);
		if (contact.count == 1) pair.rollingMoment = step.rollingMoment[contact.first];
	});
}

void Pairs::detectPoints(const Step& step, ThreadTeam& team, bool keepContacts)
{
	team.forEach(all.size(), [&](std::size_t k) {
		Pair&           pair = all[k];
		const StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		const Vec2      shift  = step.nearestShift(one, two);
		const double    maxGap = largestGap(step, one, one.alertDistance, two, two.alertDistance, shift);
		const Pose      at1 = one.pose(), at2 = shifted(two.pose(), shift);
		Manifold        detected;
		if (mayTouch(one.shape, at1, two.shape, at2, maxGap))
			detected = contactPoints(one.shape, at1, two.shape, at2, maxGap);
		pair.isNew = detected.count > 0 && pair.pointCount == 0;
		if (detected.count == 0) {
			if (!keepContacts) pair.pointCount = 0;
			return;
		}
		if (pair.isNew) pair.force[0] = pair.force[1] = {};
		if (pair.isNew || pair.pointCount != 1 || detected.count != 1) pair.rollingMoment = 0;
		double along[2];
		for (int point = 0; point < 2; ++point)
			along[point] = positionAlong(one.shape, at1, at2, detected.points[point]);
		carryForward(pair.pointCount, pair.along, detected.count, along, pair.force[0],
		        pair.force[1], LocalVector {});
		manifold[k]     = detected;
		pair.pointCount = detected.count;
		pair.shift      = shift;
		std::copy_n(along, 2, pair.along);
	});
}

void Pairs::addFoundContacts(const Step& step, long iteration)
{
	if (step.added.empty()) return;
	Neighbors::List list;
	list.reserve(all.size() + step.added.size());
	for (const Pair& pair : all)
		list.emplace_back(pair.body1, pair.body2);
	for (const FoundContact& found : step.added)
		list.emplace_back(found.body1, found.body2);
	std::sort(list.begin() + all.size(), list.end());
	std::inplace_merge(list.begin(), list.begin() + all.size(), list.end());
	list.erase(std::unique(list.begin(), list.end()), list.end());
	assign(list);
	for (const FoundContact& found : step.added) {
		Pair& pair = *std::lower_bound(all.begin(), all.end(), found, precedes);
		if (!found.known) {
			pair.law      = found.law;
			pair.formedAt = iteration;
		}
		manifold[&pair - all.data()] = found.manifold;
		pair.pointCount              = found.manifold.count;
		pair.shift                   = found.shift;
		const StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		for (int k = 0; k < 2; ++k)
			pair.along[k] = positionAlong(one.shape, one.pose(), shifted(two.pose(), found.shift),
			        found.manifold.points[k]);
	}
}

void Pairs::numberContacts(Step& step) const
{
	auto pair = all.begin();
	for (StepContact& contact : step.contacts) {
		while (precedes(*pair, contact))
			++pair;
		contact.handleIndex = int(pair - all.begin());
	}
}

void Pairs::fillStep(Step& step, ThreadTeam& team) const
{
	// numbers of pairs that touch, and of their first points
	std::vector<std::int32_t> touching, first;
	touching.reserve(all.size()), first.reserve(all.size());
	int points = 0;
	for (std::size_t k = 0; k < all.size(); ++k) {
		if (all[k].pointCount == 0) continue;
		touching.push_back(std::int32_t(k));
		first.push_back(points);
		points += all[k].pointCount;
	}
	step.contacts.resize(touching.size());
	step.resizePoints(points);
	team.forEach(touching.size(), [&](std::size_t k) {
		const std::int32_t number = touching[k];
		const Pair&        pair   = all[number];
		const double       size
		        = contactSize(step.bodies[pair.body1].shape, step.bodies[pair.body2].shape);
		step.contacts[k] = { pair.body1, pair.body2, first[k], pair.pointCount, number,
			pair.law, size, pair.shift, step.cell.drift(pair.shift) };
		step.setPoints(step.contacts[k], manifold[number], pair.force, pair.rollingMoment);
	});
}

} // namespace rcr

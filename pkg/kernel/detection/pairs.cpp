#include "detection/pairs.hpp"

#include <algorithm>
#include <utility>

#include "detection/missed_contacts.hpp"

namespace rcr {

namespace {

	/// Positions of the points of a manifold along the body by whose axis they are sorted [m].
	void positionsAlong(
	        const StepBody& one, const StepBody& two, const Manifold& manifold, double (&along)[2])
	{
		const Pose at1 = one.pose(), at2 = two.pose(), &by = orderingPose(one.shape, at1, at2);
		for (int k = 0; k < 2; ++k)
			along[k] = dot(manifold.points[k].position - by.center, by.axis);
	}

	template <class One, class Two> bool before(const One& a, const Two& b)
	{
		return a.body1 != b.body1 ? a.body1 < b.body1 : a.body2 < b.body2;
	}
	template <class One, class Two> bool same(const One& a, const Two& b)
	{
		return a.body1 == b.body1 && a.body2 == b.body2;
	}

	/// Inserts new pairs in order.
	void insert(Pairs& pairs, std::vector<Pair> more)
	{
		std::size_t from = pairs.all.size(), to = from + more.size();
		pairs.all.resize(to);
		pairs.manifold.resize(to);
		while (!more.empty()) {
			--to;
			if (from > 0 && before(more.back(), pairs.all[from - 1])) {
				--from;
				pairs.all[to]      = pairs.all[from];
				pairs.manifold[to] = pairs.manifold[from];
			} else {
				pairs.all[to] = more.back();
				more.pop_back();
			}
		}
	}

} // namespace

void Pairs::assign(const Neighbours::List& list, bool again)
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
		for (; old < all.size() && before(all[old], pair); ++old)
			if (again && all[old].points > 0) keep(old);
		if (old < all.size() && same(all[old], pair))
			keep(old++);
		else
			now.all.push_back(pair), now.manifold.emplace_back();
	}
	for (; again && old < all.size(); ++old)
		if (all[old].points > 0) keep(old);
	std::swap(*this, now);
}

void Pairs::detect(const Step& step, ThreadTeam& team, bool again)
{
	manifold.resize(all.size());
	team.forEach(all.size(), [&](std::size_t k) {
		Pair&           pair = all[k];
		const StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		const double    reach = one.alertDistance + two.alertDistance;
		pair.fresh            = false;
		if (apart(one.shape, one.center, two.shape, two.center, reach)
		        || !canTouch(one.shape.kind, two.shape.kind)) {
			if (!again) pair.points = 0;
			return;
		}
		const Manifold found = contactPoints(one.shape, one.pose(), two.shape, two.pose(), reach);
		if (found.count == 0) {
			if (!again) pair.points = 0;
			return;
		}
		manifold[k] = found;
		double along[2];
		positionsAlong(one, two, manifold[k], along);
		pair.fresh = pair.points == 0;
		if (pair.fresh) pair.force[0] = pair.force[1] = {};
		carryForward(pair.points, pair.along, manifold[k].count, along, pair.force[0],
		        pair.force[1], Impulse {});
		pair.points = manifold[k].count;
		std::copy_n(along, 2, pair.along);
	});
}

void Pairs::addFound(const Step& step, long iteration)
{
	const auto find = [&](const UpdatedContact& found) {
		return std::lower_bound(all.begin(), all.end(), found, before<Pair, UpdatedContact>);
	};
	std::vector<Pair> more;
	for (const UpdatedContact& found : step.added) {
		const auto place = find(found);
		if (place != all.end() && same(*place, found)) continue;
		more.emplace_back();
		more.back().body1 = found.body1, more.back().body2 = found.body2;
	}
	std::sort(more.begin(), more.end(), before<Pair, Pair>); // two passes may find the same pair
	more.erase(std::unique(more.begin(), more.end(), same<Pair, Pair>), more.end());
	insert(*this, std::move(more));
	for (const UpdatedContact& found : step.added) {
		Pair& pair = *find(found);
		if (pair.points == 0) {
			pair.friction = found.friction, pair.restitution = found.restitution;
			pair.since = iteration;
		}
		manifold[&pair - all.data()] = found.manifold;
		pair.points                  = found.manifold.count;
		positionsAlong(
		        step.bodies[pair.body1], step.bodies[pair.body2], found.manifold, pair.along);
	}
}

void Pairs::numberContacts(Step& step) const
{
	auto pair = all.begin();
	for (StepContact& contact : step.contacts) {
		while (before(*pair, contact))
			++pair;
		contact.source = int(pair - all.begin());
	}
}

void Pairs::writeContacts(Step& step, ThreadTeam& team) const
{
	// numbers of pairs that touch, and of their first points
	std::vector<std::int32_t> touching, first;
	touching.reserve(all.size()), first.reserve(all.size());
	int points = 0;
	for (std::size_t k = 0; k < all.size(); ++k) {
		if (all[k].points == 0) continue;
		touching.push_back(std::int32_t(k));
		first.push_back(points);
		points += all[k].points;
	}
	step.contacts.resize(touching.size());
	step.begin(points);
	team.forEach(touching.size(), [&](std::size_t k) {
		const std::int32_t number = touching[k];
		const Pair&        pair   = all[number];
		const double       size
		        = contactSize(step.bodies[pair.body1].shape, step.bodies[pair.body2].shape);
		step.contacts[k] = { pair.body1, pair.body2, first[k], pair.points, number,
			pair.restitution, size, {}, {} };
		step.setPoints(step.contacts[k], manifold[number], pair.friction, pair.force);
	});
	step.indexContacts();
}

void Pairs::keepForces(const Step& step, ThreadTeam& team)
{
	team.forEach(step.contacts.size(), [&](std::size_t k) {
		const StepContact& contact = step.contacts[k];
		std::copy_n(&step.force[contact.first], contact.count, all[contact.source].force);
	});
}

} // namespace rcr

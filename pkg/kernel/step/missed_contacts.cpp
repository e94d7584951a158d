#include "step/missed_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace rcr {

namespace {

	constexpr double further = 1.5; // times the way found: solving once more may lengthen it

	constexpr std::size_t few = 16; // bodies that look: for these, sorting all grains takes longer than asking each

	/// Grains, to be asked which may lie within a distance of a body; in a periodic cell all may. They are sorted by x where many bodies ask.
	class Neighbours {
	public:
		explicit Neighbours(const Step& step) : step_(step), fast_(step.bodies.size()), sorted_(step.lookedAgain.size() > few && !step.cell.periodic)
		{
			for (int id : step.lookedAgain)
				fast_[id] = true;
			for (std::size_t id = 0; id < step.bodies.size(); ++id) {
				const StepBody& b = step.bodies[id];
				if (b.shape.kind == PlanarShape::none) continue;
				if (!b.shape.grain()) obstacles_.push_back(int(id));
				else {
					grains_.emplace_back(b.center.x, int(id));
					if (!fast_[id]) largestSlow_ = std::max(largestSlow_, extent(int(id)));
				}
			}
			if (sorted_) std::sort(grains_.begin(), grains_.end());
		}

		/// visit(other) for all that may meet a fast body; of two fast grains the one of the larger extent finds the other.
		template <class Visit> void forEach(int id, Visit visit) const
		{
			const StepBody& b = step_.bodies[id];
			auto            from = grains_.begin(), to = grains_.end();
			if (!b.shape.grain()) {
				std::for_each(from, to, [&](const auto& grain) { visit(grain.second); });
				return;
			}
			std::for_each(obstacles_.begin(), obstacles_.end(), visit);
			const double own  = extent(id);
			const double half = step_.cell.periodic ? std::numeric_limits<double>::infinity() : own + std::max(own, largestSlow_);
			if (sorted_) {
				const auto left = [](const auto& grain, double x) { return grain.first < x; };
				from            = std::lower_bound(from, to, b.center.x - half, left);
				to              = std::lower_bound(from, to, b.center.x + half, left);
			}
			for (; from != to; ++from) {
				if (std::abs(from->first - b.center.x) > half) continue;
				const int    other = from->second;
				const double its   = extent(other);
				if (fast_[other] && (its > own || (its == own && other <= id))) continue;
				const Vec2   between = step_.bodies[other].center - b.center, apart = between + step_.cell.nearestShift(between);
				const double most    = own + its;
				if (dot(apart, apart) <= most * most) visit(other);
			}
		}

	private:
		/// Of the circle in which a grain looks for contacts.
		double extent(int id) const { return step_.bodies[id].radius + reachOf(step_, id); }

		const Step&       step_;
		std::vector<bool> fast_;
		const bool        sorted_;
		std::vector<int>  obstacles_;
		double            largestSlow_ = 0;
		std::vector<std::pair<double, int>> grains_; // x and number
	};

	/// Bodies that go further than expected, and further than they have looked.
	void findFastBodies(Step& step)
	{
		step.lookedAgain.clear();
		for (std::size_t id = 0; id < step.bodies.size(); ++id) {
			const StepBody& b = step.bodies[id];
			if (b.shape.kind == PlanarShape::none) continue;
			const double way = step.dt * speed(step.problem.velocity[id], b.radius);
			if (!(way > b.expected) || way <= step.reach[id]) continue;
			step.reach[id] = std::max(b.alertDistance, step.reach[id]) + further * way;
			step.lookedAgain.push_back(int(id));
		}
	}

	/// Would a point of the manifold, which the law did not know, close beyond the slop?
	bool closes(const Step& step, const GrownContact& pair)
	{
		const StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		for (int k = 0; k < pair.manifold.count; ++k) {
			ContactPoint c;
			c.normal         = pair.manifold.points[k].normal;
			c.arm1           = pair.manifold.points[k].position - one.center;
			c.arm2           = pair.manifold.points[k].position - (two.center + pair.shift);
			c.drift          = step.cell.drift(pair.shift);
			const double gap = pair.manifold.points[k].gap, u = relativeVelocity(c, step.problem.velocity[pair.body1], step.problem.velocity[pair.body2]).n;
			if (gap + step.dt * u < -contactSlop * contactSize(one.shape, two.shape)) return true;
		}
		return false;
	}

	/// Sorted by their bodies, of each pair the last alone.
	void keepLast(std::vector<GrownContact>& grown)
	{
		const auto before = [](const GrownContact& a, const GrownContact& b) { return a.body1 != b.body1 ? a.body1 < b.body1 : a.body2 < b.body2; };
		const auto same   = [&](const GrownContact& a, const GrownContact& b) { return !before(a, b) && !before(b, a); };
		std::stable_sort(grown.begin(), grown.end(), before);
		grown.erase(grown.begin(), std::unique(grown.rbegin(), grown.rend(), same).base());
	}

	/// One pair at the reach that it has now; true if it closes unknown.
	bool look(Step& step, int id, int other, const MayMeet& mayMeet)
	{
		if (step.bodies[id].owner == step.bodies[other].owner) return false;
		const auto   kind    = [&](int body) { return step.bodies[body].shape.kind; };
		const bool   ordered = kind(id) != kind(other) ? kind(id) < kind(other) : id < other;
		GrownContact pair;
		pair.body1 = ordered ? id : other;
		pair.body2 = ordered ? other : id;
		if (!canTouch(kind(pair.body1), kind(pair.body2))) return false;
		const StepBody &   one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		const StepContact* contact = step.find(pair.body1, pair.body2);
		Pose               at2     = two.pose();
		pair.shift                 = contact ? contact->shift : step.cell.nearestShift(two.center - one.center);
		pair.known                 = contact;
		at2.center                 = at2.center + pair.shift;
		const double reach         = reachOf(step, pair.body1) + reachOf(step, pair.body2);
		pair.manifold              = contactPoints(one.shape, one.pose(), two.shape, at2, reach);
		if (pair.manifold.count == (contact ? contact->count : 0) || (!contact && !mayMeet(pair.body1, pair.body2))) return false;
		step.grown.push_back(pair);
		return closes(step, pair);
	}

} // namespace

double reachOf(const Step& step, std::size_t id) { return std::max(step.bodies[id].alertDistance, id < step.reach.size() ? step.reach[id] : 0); }

bool findMissedContacts(Step& step, const MayMeet& mayMeet)
{
	step.reach.resize(step.bodies.size());
	findFastBodies(step);
	if (step.lookedAgain.empty()) return false;
	const Neighbours neighbours(step);
	bool             missed = false;
	for (int id : step.lookedAgain)
		neighbours.forEach(id, [&](int other) { missed |= look(step, id, other, mayMeet); });
	keepLast(step.grown);
	return missed;
}

namespace {

	/// Where a point lies along the body by whose axis the points of the pair are sorted.
	double along(const Step& step, const StepContact& c, Vec2 position)
	{
		const StepBody &one = step.bodies[c.body1], &two = step.bodies[c.body2];
		Pose            at2 = two.pose();
		at2.center          = at2.center + c.shift;
		const Pose at1      = one.pose(), &by = orderingPose(one.shape, at1, at2);
		return dot(position - by.center, by.axis);
	}

	/// Forces of the points that a contact had go to the nearest ones that it has: others have just opened or closed.
	void handOn(const Step& step, const StepContact& old, const Manifold& now, Impulse* force)
	{
		if (old.count == now.count) {
			std::copy_n(step.force.begin() + old.first, old.count, force);
			return;
		}
		for (int k = 0; k < now.count; ++k)
			force[k] = {};
		const auto atOld = [&](int k) { return along(step, old, step.point(old, k).position); };
		const auto atNow = [&](int k) { return along(step, old, now.points[k].position); };
		if (old.count == 1) {
			const bool second = std::abs(atNow(1) - atOld(0)) < std::abs(atNow(0) - atOld(0));
			force[second]     = step.force[old.first];
		} else if (now.count == 1) {
			const bool second = std::abs(atOld(1) - atNow(0)) < std::abs(atOld(0) - atNow(0));
			force[0]          = step.force[old.first + second];
		}
	}

	struct Entry {
		StepContact         contact; // `first` as it was
		const GrownContact* grown;   // null: as it was
	};

	/// The contacts as they are to be, in order.
	std::vector<Entry> entries(const Step& step)
	{
		std::vector<Entry> all;
		all.reserve(step.contacts.size() + step.grown.size());
		for (const StepContact& c : step.contacts)
			all.push_back({ c, nullptr });
		for (const GrownContact& g : step.grown) {
			if (g.known) {
				all[step.find(g.body1, g.body2) - step.contacts.data()].grown = &g;
				continue;
			}
			const double size = contactSize(step.bodies[g.body1].shape, step.bodies[g.body2].shape);
			all.push_back({ { g.body1, g.body2, 0, 0, -1, g.restitution, size, g.shift, step.cell.drift(g.shift) }, &g });
		}
		std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) {
			return a.contact.body1 != b.contact.body1 ? a.contact.body1 < b.contact.body1 : a.contact.body2 < b.contact.body2;
		});
		return all;
	}

} // namespace

void takeInGrownContacts(Step& step)
{
	std::vector<char> anew(step.bodies.size()); // bodies whose contacts start from what the law says at the beginning
	for (int id : step.lookedAgain)
		anew[id] = true;
	std::vector<StepContact>  contacts;
	std::vector<ContactPoint> points;
	std::vector<Impulse>      forces;
	std::vector<Gap>          gaps;
	for (const Entry& entry : entries(step)) {
		const StepContact&  old   = entry.contact;
		const GrownContact* grown = entry.grown;
		StepContact         c     = old;
		c.first                   = int(points.size());
		c.count                   = grown ? grown->manifold.count : old.count;
		forces.resize(c.first + c.count);
		if (grown && grown->known) handOn(step, old, grown->manifold, &forces[c.first]);
		for (int k = 0; k < c.count; ++k) {
			const int           number   = old.first + k;
			const double        friction = grown && !grown->known ? grown->friction : step.problem.points[old.first].friction;
			const ManifoldPoint at       = grown ? grown->manifold.points[k] : step.point(old, k);
			ContactPoint        point    = step.contactPoint(c, at, friction);
			if (!grown) {
				const double bias = anew[c.body1] || anew[c.body2] ? point.bias : step.problem.points[number].bias;
				point             = step.problem.points[number];
				point.bias        = bias;
				forces[c.first + k] = step.force[number];
			}
			points.push_back(point);
			gaps.push_back({ at.gap, -c.slop(), number < old.first + old.count && step.gap[number].carried });
		}
		contacts.push_back(c);
	}
	step.contacts.swap(contacts);
	step.problem.points.swap(points);
	step.force.swap(forces);
	step.gap.swap(gaps);
	step.indexContacts();
	step.startFromForces();
	step.taken.insert(step.taken.end(), step.grown.begin(), step.grown.end());
	step.grown.clear();
}

} // namespace rcr

#include "detection/missed_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "correction/large_displacements.hpp"
#include "step/carry_forward.hpp"

namespace rcr {

namespace {

	// widened reach over the path; a further solve may lengthen the path
	constexpr double      reachFactor = 1.5;
	// up to this number of widened bodies, a linear search beats sorting
	constexpr std::size_t fewBodies   = 16;

	/// Candidates for contacts of widened bodies. Grains are sorted by x if many bodies are widened
	/// and the scene is open.
	class Candidates {
	public:
		Candidates(const Step& step, const std::vector<std::int32_t>& widened)
		        : step_(step)
		        , fast_(step.bodies.size())
		        , sorted_(widened.size() > fewBodies && !step.cell.periodic)
		{
			for (int id : widened)
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

		/// Calls visit(other) for all bodies that a widened body may meet. Of two widened grains,
		/// the larger one finds the other.
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
			const double half = step_.cell.periodic ? std::numeric_limits<double>::infinity()
			                                        : own + std::max(own, largestSlow_);
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
				const Vec2 between   = step_.bodies[other].center - b.center,
				           apart     = between + step_.cell.nearestShift(between);
				const double most    = own + its;
				if (dot(apart, apart) <= most * most) visit(other);
			}
		}

	private:
		/// Radius of the circle in which contacts of a grain are detected.
		double extent(int id) const { return step_.bodies[id].radius + reachOf(step_, id); }

		const Step&       step_;
		std::vector<bool> fast_;
		const bool        sorted_;
		std::vector<int>  obstacles_;
		double            largestSlow_ = 0;
		std::vector<std::pair<double, int>> grains_; // x and number
	};

	/// Widens the reach of bodies whose path exceeds it, and returns these bodies.
	std::vector<std::int32_t> widenReach(Step& step)
	{
		std::vector<std::int32_t> widened;
		for (std::size_t id = 0; id < step.bodies.size(); ++id) {
			const StepBody& b = step.bodies[id];
			if (b.shape.kind == PlanarShape::none) continue;
			const double path = step.pathOf(int(id), step.problem.velocity[id]);
			if (!(path > b.expected) || path <= step.reach[id]) continue;
			step.reach[id] = std::max(b.alertDistance, step.reach[id]) + reachFactor * path;
			widened.push_back(std::int32_t(id));
		}
		return widened;
	}

	/// A new contact of the step.
	StepContact newContact(const Step& step, const UpdatedContact& pair)
	{
		const double size
		        = contactSize(step.bodies[pair.body1].shape, step.bodies[pair.body2].shape);
		return { pair.body1, pair.body2, 0, 0, -1, pair.friction, pair.restitution, size,
			pair.shift, step.cell.drift(pair.shift) };
	}

	/// A point of the contact closes beyond the slop at the solved velocities. A new contact with a
	/// large displacement also closes if its bodies meet on their curved paths.
	bool closes(const Step& step, const UpdatedContact& pair)
	{
		if (pair.manifold.count == 0) return false;
		const StepContact contact = newContact(step, pair);
		if (!pair.known && displacesFar(step, contact)
		        && meetOnPaths(step, contact, pair.manifold.points[0].normal))
			return true;
		const StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
		for (int k = 0; k < pair.manifold.count; ++k) {
			ContactPoint c;
			c.normal         = pair.manifold.points[k].normal;
			c.arm1           = pair.manifold.points[k].position - one.center;
			c.arm2           = pair.manifold.points[k].position - (two.center + pair.shift);
			c.drift          = contact.drift;
			const double gap = pair.manifold.points[k].gap,
			             u   = relativeVelocity(c, step.problem.velocity[pair.body1],
			                       step.problem.velocity[pair.body2])
			                         .n;
			if (gap + step.dt * u < -contact.slop()) return true;
		}
		return false;
	}

	/// Sorts by bodies and keeps the last entry of each pair.
	void keepLastOfEach(std::vector<UpdatedContact>& updated)
	{
		const auto same = [](const UpdatedContact& a, const UpdatedContact& b) {
			return a.body1 == b.body1 && a.body2 == b.body2;
		};
		std::stable_sort(updated.begin(), updated.end(), precedes);
		updated.erase(updated.begin(), std::unique(updated.rbegin(), updated.rend(), same).base());
	}

	/// The contact has as many points as the manifold; `exact`: and the same gaps.
	bool isKnown(const Step& step, const StepContact* contact, const Manifold& now, bool exact)
	{
		if (now.count != (contact ? contact->count : 0)) return false;
		for (int k = 0; exact && k < now.count; ++k)
			if (step.gap[contact->first + k].now != now.points[k].gap) return false;
		return true;
	}

	/// Detects a pair with its present reach and collects it if it is not known so (isKnown).
	void checkPair(Step& step, int id, int other, const MayMeet& mayMeet, bool exact = false)
	{
		if (step.bodies[id].owner == step.bodies[other].owner) return;
		const auto shape = [&](int body) -> const PlanarShape& { return step.bodies[body].shape; };
		if (!comesFirst(shape(id), id, shape(other), other)) std::swap(id, other);
		// the simulation may hold a contact of equal kinds in either order
		if (shape(id).kind == shape(other).kind && step.find(other, id)) std::swap(id, other);
		if (!canTouch(shape(id).kind, shape(other).kind)) return;
		const StepBody &   one = step.bodies[id], &two = step.bodies[other];
		const StepContact* contact = step.find(id, other);
		UpdatedContact     pair;
		pair.body1 = id;
		pair.body2 = other;
		pair.shift = contact ? contact->shift : step.cell.nearestShift(two.center - one.center);
		pair.known = contact;
		pair.manifold = contactPoints(one.shape, one.pose(), two.shape,
		        shifted(two.pose(), pair.shift), reachOf(step, id) + reachOf(step, other));
		if (isKnown(step, contact, pair.manifold, exact)) return;
		// keeps a contact beyond a smaller reach
		if (exact && pair.manifold.count == 0) return;
		if (!contact && !mayMeet(id, other)) return;
		step.updated.push_back(pair);
	}

} // namespace

bool mayMeetTwoImages(const Step& step)
{
	if (!step.cell.periodic) return false;
	double widest = 0, second = 0;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const StepBody& b = step.bodies[id];
		if (b.shape.kind == PlanarShape::none) continue;
		const double extent = b.radius + step.pathOf(int(id), step.problem.velocity[id]);
		second              = std::max(second, std::min(widest, extent));
		widest              = std::max(widest, extent);
	}
	return widest + second > 0.5 * step.cell.smallestHeight();
}

double reachOf(const Step& step, std::size_t id)
{
	return std::max(step.bodies[id].alertDistance, id < step.reach.size() ? step.reach[id] : 0);
}

bool findUnlistedContacts(
        Step& step, const std::vector<std::int32_t>& bodies, const MayMeet& mayMeet)
{
	const Candidates candidates(step, bodies);
	for (int id : bodies)
		candidates.forEach(id, [&](int other) { checkPair(step, id, other, mayMeet, true); });
	keepLastOfEach(step.updated);
	return !step.updated.empty();
}

bool findMissedContacts(Step& step, const MayMeet& mayMeet)
{
	step.reach.resize(step.bodies.size());
	const std::vector<std::int32_t> widened = widenReach(step);
	if (!widened.empty()) {
		const Candidates candidates(step, widened);
		for (int id : widened)
			candidates.forEach(id, [&](int other) { checkPair(step, id, other, mayMeet); });
		keepLastOfEach(step.updated);
		step.widened.insert(step.widened.end(), widened.begin(), widened.end());
	}
	// those of earlier solves may close at the present velocities
	return std::any_of(step.updated.begin(), step.updated.end(),
	        [&](const UpdatedContact& pair) { return closes(step, pair); });
}

namespace {

	/// Force from which a point starts. `carried`: it bore a force when the step began.
	struct Start {
		Impulse force;
		bool    carried = false;
	};

	/// Starts of the points that a contact has now (null: unchanged), from those that it had.
	std::array<Start, 2> startsOf(const Step& step, const StepContact& old, const Manifold* now)
	{
		std::array<Start, 2> start;
		for (int k = 0; k < old.count; ++k)
			start[k] = { step.force[old.first + k], step.gap[old.first + k].carried };
		if (!now || old.count == now->count) return start;
		const StepBody &one = step.bodies[old.body1], &two = step.bodies[old.body2];
		const auto      along = [&](Vec2 position) {
            return positionAlong(one.shape, one.pose(), shifted(two.pose(), old.shift), position);
		};
		double before[2] {}, after[2] {};
		for (int k = 0; k < old.count; ++k)
			before[k] = along(step.point(old, k).position);
		for (int k = 0; k < now->count; ++k)
			after[k] = along(now->points[k].position);
		carryForward(old.count, before, now->count, after, start[0], start[1], Start {});
		return start;
	}

	struct Entry {
		StepContact           contact; // with its old number of the first point
		const UpdatedContact* updated; // null: unchanged
	};

	/// Old and new contacts, sorted by bodies.
	std::vector<Entry> entries(const Step& step)
	{
		std::vector<Entry> all;
		all.reserve(step.contacts.size() + step.updated.size());
		for (const StepContact& c : step.contacts)
			all.push_back({ c, nullptr });
		for (const UpdatedContact& g : step.updated) {
			if (g.known) all[step.find(g.body1, g.body2) - step.contacts.data()].updated = &g;
			else
				all.push_back({ newContact(step, g), &g });
		}
		std::sort(all.begin(), all.end(),
		        [](const Entry& a, const Entry& b) { return precedes(a.contact, b.contact); });
		return all;
	}

} // namespace

void addUpdatedContacts(Step& step)
{
	// bodies whose contacts start with their initial bias
	std::vector<char> restarted(step.bodies.size());
	for (int id : step.widened)
		restarted[id] = true;
	std::vector<StepContact>  contacts;
	std::vector<ContactPoint> points;
	std::vector<Impulse>      forces, impulses;
	std::vector<Gap>          gaps;
	for (const auto& [old, updated] : entries(step)) {
		StepContact c = old;
		c.first       = int(points.size());
		c.count       = updated ? updated->manifold.count : old.count;
		const std::array<Start, 2> start
		        = startsOf(step, old, updated ? &updated->manifold : nullptr);
		for (int k = 0; k < c.count; ++k) {
			const ManifoldPoint at = updated ? updated->manifold.points[k] : step.point(old, k);
			const ContactPoint  initial = step.contactPoint(c, at);
			points.push_back(updated ? initial : step.problem.points[old.first + k]);
			if (restarted[c.body1] || restarted[c.body2]) points.back().bias = initial.bias;
			impulses.push_back(step.dt * start[k].force);
			forces.push_back(start[k].force);
			// before the first solve, no body was widened
			const bool carried = step.widened.empty() ? start[k].force.n > 0 : start[k].carried;
			gaps.push_back({ at.gap, -c.slop(), carried });
		}
		contacts.push_back(c);
	}
	step.contacts.swap(contacts);
	step.problem.points.swap(points);
	step.problem.impulse.swap(impulses);
	step.force.swap(forces);
	step.gap.swap(gaps);
	step.indexContacts();
	step.added.insert(step.added.end(), step.updated.begin(), step.updated.end());
	step.updated.clear();
	step.widened.clear();
}

} // namespace rcr

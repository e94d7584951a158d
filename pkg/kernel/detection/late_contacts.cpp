#include "detection/late_contacts.hpp"

#include <array>

#include "detection/large_displacements.hpp"
#include "step/carry_forward.hpp"

namespace rcr {

namespace {

	// widening over the path; a further solve may lengthen the path
	constexpr double wideningFactor = 1.5;

	/// Returns true if images move beyond the reach in which their contacts were detected.
	bool imagesLeaveReach(const Step& step)
	{
		if (!step.cell.periodic) return false;
		double floor = std::numeric_limits<double>::infinity();
		for (const StepBody& b : step.bodies)
			if (b.shape.grain()) floor = std::min(floor, imageReach(b.shape, 0, step.dt));
		return step.dt * step.cell.largestDrift() > 2 * step.dt * step.cell.imageSpeed + floor;
	}

	/// Widens the reach of bodies with longer paths and returns these bodies; all bodies if images
	/// leave their reach.
	std::vector<std::int32_t> widenReach(Step& step)
	{
		std::vector<std::int32_t> widened;
		const bool                images = imagesLeaveReach(step);
		if (images) step.cell.imageSpeed = step.cell.largestDrift();
		for (std::size_t id = 0; id < step.bodies.size(); ++id) {
			const StepBody& b = step.bodies[id];
			if (b.shape.kind == PlanarShape::none) continue;
			const double path = step.pathOf(int(id), step.velocityToEnd(int(id)));
			const bool   longer = path > b.coveredPath && path > step.widenedReach[id];
			if (longer) step.widenedReach[id] = detectionReach(step, id) + wideningFactor * path;
			if (longer || images) widened.push_back(std::int32_t(id));
		}
		return widened;
	}

	/// A found contact as a contact of the step without points.
	StepContact newContact(const Step& step, const FoundContact& found)
	{
		const double size = contactSize(
		        step.bodies[found.body1].shape, step.bodies[found.body2].shape);
		return { found.body1, found.body2, 0, 0, -1, found.law, size,
			found.shift, step.cell.drift(found.shift) };
	}

	/// Returns true if a point closes beyond the slop at the solved velocities. A new contact with
	/// a large displacement also closes if its bodies meet on their curved paths.
	bool closes(const Step& step, const FoundContact& found)
	{
		if (found.manifold.count == 0) return false;
		const StepContact contact = newContact(step, found);
		if (!found.known && hasLargeDisplacement(step, contact) && meetOnPaths(step, contact))
			return true;
		const int body1 = found.body1, body2 = found.body2;
		for (int k = 0; k < found.manifold.count; ++k) {
			const ManifoldPoint& at = found.manifold.points[k];
			ContactPoint         c;
			c.normal       = at.normal;
			c.arm1         = at.position - step.bodies[body1].center;
			c.arm2         = at.position - (step.bodies[body2].center + found.shift);
			c.drift        = contact.drift;
			const double u = relativeVelocity(
			        c, step.problem.velocity[body1], step.problem.velocity[body2]).n;
			if (at.gap + step.dt * u < -contact.slop()) return true;
		}
		return false;
	}

	/// Sorts by bodies and keeps the last entry of each pair.
	void keepLastOfEach(std::vector<FoundContact>& contacts)
	{
		const auto same = [](const FoundContact& a, const FoundContact& b) {
			return a.body1 == b.body1 && a.body2 == b.body2;
		};
		std::stable_sort(contacts.begin(), contacts.end(), precedes);
		contacts.erase(
		        contacts.begin(), std::unique(contacts.rbegin(), contacts.rend(), same).base());
	}

	/// Returns true if the contact has as many points as the manifold; `exact`: with the same gaps.
	bool isKnown(const Step& step, const StepContact* contact, const Manifold& now, bool exact)
	{
		if (now.count != (contact ? contact->count : 0)) return false;
		for (int k = 0; exact && k < now.count; ++k)
			if (step.gap[contact->first + k].atStart != now.points[k].gap) return false;
		return true;
	}

	/// Detects a pair within its present reach and collects it unless isKnown.
	void checkPair(
	        Step& step, int id, int other, const ContactFilter& allowsContact, bool exact)
	{
		if (step.bodies[id].owner == step.bodies[other].owner) return;
		const auto shape = [&](int body) -> const PlanarShape& { return step.bodies[body].shape; };
		if (!comesFirst(shape(id), id, shape(other), other)) std::swap(id, other);
		// the simulation may hold a contact of equal kinds in either order
		if (shape(id).kind == shape(other).kind && step.find(other, id)) std::swap(id, other);
		if (!canTouch(shape(id).kind, shape(other).kind)) return;
		const StepBody &   one = step.bodies[id], &two = step.bodies[other];
		const StepContact* contact = step.find(id, other);
		FoundContact       found;
		found.body1    = id;
		found.body2    = other;
		found.shift    = contact ? contact->shift : step.nearestShift(one, two);
		found.known    = contact;
		const double near = largestGap(step, one, detectionReach(step, id), two,
		        detectionReach(step, other), found.shift);
		// a known contact keeps the points that its pull reaches
		found.manifold = contactPoints(one.shape, one.pose(), two.shape,
		        shifted(two.pose(), found.shift),
		        contact ? std::max(near, contact->law.adhesionRange) : near);
		if (isKnown(step, contact, found.manifold, exact)) return;
		// keeps a contact beyond a smaller reach
		if (exact && found.manifold.count == 0) return;
		if (!contact && !allowsContact(id, other)) return;
		step.found.push_back(found);
	}

	/// Force from which a point starts, and Gap::loadedBefore.
	struct Start {
		LocalVector force;
		bool        loadedBefore = false;
		double      rollingMoment = 0;
	};

	/// Starts of the points `now` (null: unchanged) from the points of the old contact.
	std::array<Start, 2> startsOf(const Step& step, const StepContact& old, const Manifold* now)
	{
		std::array<Start, 2> start;
		for (int k = 0; k < old.count; ++k)
			start[k] = { step.force[old.first + k], step.gap[old.first + k].loadedBefore,
				step.rollingMoment[old.first + k] };
		if (!now) return start;
		const StepBody &one = step.bodies[old.body1], &two = step.bodies[old.body2];
		const auto      along = [&](const ManifoldPoint& point) {
            return positionAlong(one.shape, one.pose(), shifted(two.pose(), old.shift), point);
		};
		double before[2] {}, after[2] {};
		for (int k = 0; k < old.count; ++k)
			before[k] = along(step.point(old, k));
		for (int k = 0; k < now->count; ++k)
			after[k] = along(now->points[k]);
		carryForward(old.count, before, now->count, after, start[0], start[1], Start {});
		return start;
	}

} // namespace

bool spansHalfCell(const Step& step)
{
	if (!step.cell.periodic) return false;
	double widest = 0, second = 0;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const StepBody& b = step.bodies[id];
		if (b.shape.kind == PlanarShape::none) continue;
		PlanarVector v    = step.problem.velocity[id];
		const Vec2   flow = product(step.cell.gradient, b.center); // moves all bodies alike
		v.x -= flow.x, v.y -= flow.y;
		const double extent = b.radius + step.pathOf(int(id), v);
		second              = std::max(second, std::min(widest, extent));
		widest              = std::max(widest, extent);
	}
	return widest + second > 0.5 * step.cell.smallestHeight();
}

double detectionReach(const Step& step, std::size_t id)
{
	return std::max(step.bodies[id].alertDistance, step.widenedReach[id]);
}

/// Collects in step.found the contacts of these bodies.
static void checkBodies(Step& step, const std::vector<std::int32_t>& bodies, const Search& search,
        bool exact)
{
	const auto reach = [&](int id) {
		const double toImages = step.cell.periodic
		        ? imageReach(step.bodies[id].shape, step.cell.imageSpeed, step.dt) : 0;
		return detectionReach(step, id) + toImages;
	};
	search.neighbors.forEachAround(step, search.team, bodies, reach, [&](int id, int other) {
		checkPair(step, id, other, search.allows, exact);
	});
	keepLastOfEach(step.found);
}

bool findUnlistedContacts(
        Step& step, const std::vector<std::int32_t>& bodies, const Search& search)
{
	checkBodies(step, bodies, search, true);
	return !step.found.empty();
}

/// Collects in step.found the contacts of bodies whose paths exceed their reach.
static void collectContacts(Step& step, const Search& search)
{
	const std::vector<std::int32_t> widened = widenReach(step);
	if (widened.empty()) return;
	checkBodies(step, widened, search, false);
	step.widened.insert(step.widened.end(), widened.begin(), widened.end());
}

bool findLateContacts(Step& step, const Search& search)
{
	collectContacts(step, search);
	// contacts found after earlier solves may close at the present velocities
	return std::any_of(step.found.begin(), step.found.end(),
	        [&](const FoundContact& found) { return closes(step, found); });
}

std::vector<StepContact> contactsOfDisplaced(Step& step, const Search& search)
{
	collectContacts(step, search);
	std::vector<StepContact> contacts;
	for (const FoundContact& found : step.found)
		if (!found.known) contacts.push_back(newContact(step, found));
	return contacts;
}

void addFoundContacts(Step& step)
{
	// bodies whose contacts restart from their initial bias
	std::vector<char> restarted(step.bodies.size());
	for (int id : step.widened)
		restarted[id] = true;
	std::vector<StepContact>  contacts;
	std::vector<ContactPoint> points;
	std::vector<LocalVector>  forces, impulses;
	std::vector<double>       rollingMoments, rollingImpulses;
	std::vector<Gap>          gaps;
	// null: unchanged
	const auto add = [&](const StepContact& old, const FoundContact* found) {
		StepContact c = old;
		c.first       = int(points.size());
		c.count       = found ? found->manifold.count : old.count;
		const std::array<Start, 2> start = startsOf(step, old, found ? &found->manifold : nullptr);
		for (int k = 0; k < c.count; ++k) {
			const ManifoldPoint at = found ? found->manifold.points[k] : step.point(old, k);
			const ContactPoint  initial = step.contactPoint(c, at);
			points.push_back(found ? initial : step.problem.points[old.first + k]);
			if (restarted[c.body1] || restarted[c.body2]) points.back().bias = initial.bias;
			impulses.push_back(step.dt * start[k].force);
			forces.push_back(start[k].force);
			rollingMoments.push_back(points.back().rolls() ? start[k].rollingMoment : 0);
			rollingImpulses.push_back(step.rollingImpulse(points.back(), rollingMoments.back()));
			// before the first solve, no body was widened
			const bool loaded = step.widened.empty() ? start[k].force.n != 0 : start[k].loadedBefore;
			gaps.push_back({ at.gap, -c.slop(), loaded });
		}
		contacts.push_back(c);
	};
	// both lists are sorted
	auto found = step.found.begin();
	for (const StepContact& old : step.contacts) {
		for (; found != step.found.end() && precedes(*found, old); ++found)
			add(newContact(step, *found), &*found);
		const bool changes = found != step.found.end() && !precedes(old, *found);
		add(old, changes ? &*found++ : nullptr);
	}
	for (; found != step.found.end(); ++found)
		add(newContact(step, *found), &*found);
	step.contacts.swap(contacts);
	step.problem.points.swap(points);
	step.problem.impulse.swap(impulses);
	step.problem.rollingImpulse.swap(rollingImpulses);
	step.force.swap(forces);
	step.rollingMoment.swap(rollingMoments);
	step.gap.swap(gaps);
	step.added.insert(step.added.end(), step.found.begin(), step.found.end());
	step.found.clear();
	step.widened.clear();
}

} // namespace rcr

#include "detection/large_displacements.hpp"

namespace rcr {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int    samples         = 4; // times within the step at which gaps are measured
constexpr int    nearMissSamples = 8; // times at which contacts with restitution are measured
// least gap over the slop of a contact that is released
constexpr double clearance       = 0.02;
// its value if the point bore a force before the step, without restitution
constexpr double loadedClearance = 0.5;
// overlap that counts as an intrusion is 1 less this, over the smaller cap radius
constexpr double closeToIntrusion = 0.02;
constexpr int    mostAdvances     = 1000; // in time; turning needles in contact take most
// a contact stays if its gap is below this share of the path, and below the slop
constexpr double earlyArrival    = 0.01;

static PlanarVector initial(const Step& step, int id)
{
	return step.stretched(id, step.initialVelocity(id));
}

/// Returns true if the points have changed their order since the beginning of the step. The
/// first body has then turned against the second one.
static bool isReversed(const Step& step, const StepContact& c, const Manifold& now)
{
	return dot(now.points[1].position - now.points[0].position,
	        step.point(c, 1).position - step.point(c, 0).position) < 0;
}

/// Gap of point k of the contact, or the smallest gap if the number of points changed; inf: out
/// of reach; −inf: the point is on the far side of the body.
static double gapOf(const Step& step, const StepContact& c, int k, const Manifold& now)
{
	if (now.count == 0) return infinity;
	const Vec2 normal = step.problem.points[c.first + k].normal;
	const bool closer = now.count == 2 && now.points[1].gap < now.points[0].gap;
	const int  at     = now.count != c.count           ? closer
	        : now.count == 2 && isReversed(step, c, now) ? 1 - k
	                                                     : k;
	return dot(now.points[at].normal, normal) > 0 ? now.points[at].gap : -infinity;
}

Manifold solvedPointsAfter(const Step& step, const StepContact& c, double time)
{
	return pointsAfter(step, c, time, [&](int id) { return step.problem.velocity[id]; });
}

bool passedThrough(const Step& step, const StepContact& contact, Vec2 normalBefore,
        const Manifold& now, double time)
{
	constexpr int halvings = 10;
	if (now.count == 0 || dot(now.points[0].normal, normalBefore) > 0) return false;
	Vec2   normalAfter = now.points[0].normal;
	double before = 0, after = time;
	for (int k = 0; k < halvings; ++k) {
		const double   middle = 0.5 * (before + after);
		const Manifold at     = solvedPointsAfter(step, contact, middle);
		if (at.count == 0) return false;
		const Vec2 normal = at.points[0].normal;
		if (dot(normal, normalBefore) < 0) after = middle, normalAfter = normal;
		else if (dot(normal, normalAfter) < 0)
			before = middle;
		else
			return false;
	}
	return true;
}

/// Inscribed radius of the thinner grain of a contact [m].
static double thinnerRadius(const Step& step, const StepContact& c)
{
	const PlanarShape &one = step.bodies[c.body1].shape, &two = step.bodies[c.body2].shape;
	return one.grain() ? std::min(one.inscribedRadius(), two.inscribedRadius())
	                   : two.inscribedRadius();
}

bool intrudesOnPath(const Step& step, const StepContact& contact)
{
	const auto   velocityOf = [&](int id) { return step.problem.velocity[id]; };
	const double allowed = thinnerRadius(step, contact), close = closeToIntrusion * allowed;
	const PlanarVector v1 = velocityOf(contact.body1), v2 = velocityOf(contact.body2);
	const Vec2         shift    = relativeShift(step, contact, v1, v2);
	const double       rotation = rotationPath(step, contact, v1, v2);
	// overlaps at the beginning of a step are small
	if (norm(shift) + rotation < allowed - close) return false;
	double share = 0; // of the step
	for (int advance = 0; advance < mostAdvances; ++advance) {
		const Manifold now
		        = pointsAfter(step, contact, share * step.dt, velocityOf, infinity);
		const ManifoldPoint& at
		        = now.points[now.count == 2 && now.points[1].gap < now.points[0].gap];
		const double left = at.gap + allowed; // until the overlap is as deep as allowed
		if (left <= close) return share > 0;
		// convex bodies stay apart along a fixed normal for at least this share of the step
		share += left / (std::max(0.0, -dot(shift, at.normal)) + rotation);
		if (!(share < 1)) return false;
	}
	return false; // a thin grain turns while it slides along another one
}

bool meetOnPaths(const Step& step, const StepContact& contact)
{
	for (int sample = 1; sample <= samples; ++sample)
		if (solvedPointsAfter(step, contact, step.dt * sample / samples).deepest() > contact.slop())
			return true;
	return intrudesOnPath(step, contact);
}

/// Returns true if the point has had restitution from the beginning of the step.
static bool rebounds(const Step& step, const StepContact& contact, int k)
{
	return contact.law.restitution > 0 && step.problem.points[contact.first + k].bias < 0;
}

bool adaptToDisplacement(Step& step, const StepContact& contact, bool allowRelease)
{
	if (rebounds(step, contact, 0) && (contact.count == 1 || rebounds(step, contact, 1)))
		return false;
	const double dt = step.dt, slop = contact.slop();
	Manifold     at[samples];
	for (int sample = 0; sample < samples; ++sample)
		at[sample] = solvedPointsAfter(step, contact, dt * (sample + 1) / samples);
	const Vec2 normal = step.problem.points[contact.first].normal;
	int        last   = samples; // the last sample at which the body is on this side
	while (last > 0 && passedThrough(step, contact, normal, at[last - 1], dt * last / samples))
		--last;
	if (last == 0) return false; // no sample is on this side, so the gaps are unknown
	bool changed = false;
	for (int k = 0; k < contact.count; ++k) {
		const int     number = contact.first + k;
		ContactPoint& c      = step.problem.points[number];
		const double  gap    = step.gap[number].atStart;
		const double  path   = dt * relativeVelocity(step.problem, c).n;
		double        least  = infinity;
		for (const Manifold& now : at)
			least = std::min(least, gapOf(step, contact, k, now));
		const double share = double(last) / samples, end = gapOf(step, contact, k, at[last - 1]);
		// the contact has moved round the body; `separate` removes its overlap
		if (end == -infinity) continue;
		const bool sinks
		        = (end < std::min(0.0, gap) - slop || last < samples) && std::isfinite(end);
		const double open     = contact.law.restitution > 0
		            ? clearance * slop
		            : std::max((step.gap[number].loadedBefore ? loadedClearance : clearance) * slop,
		                    std::min(slop, -earlyArrival * path));
		const bool   released = allowRelease && step.problem.impulse[number].n > 0 && least > open
		        && std::isfinite(least);
		if (rebounds(step, contact, k) || (!sinks && !released)) continue;
		const double before = step.initialVelocity(c).n;
		// restitution within the step
		if (sinks && contact.law.restitution > 0 && before < 0 && c.bias > 0) {
			c.bias  = contact.law.restitution * before;
			changed = true;
			continue;
		}
		const double curve = sinks ? (end - gap - share * path) / (share * share)
		        : 2 * least - gap - path; // with 1 instead of 2, one of two loaded contacts stays
		// at most an elastic impact
		const double bias   = std::max((std::max(gap, 0.0) + curve) / dt, std::min(0.0, before));
		if (dt * std::abs(bias - c.bias) < clearance * slop) continue;
		c.bias  = bias;
		changed = true;
	}
	return changed;
}

bool releaseNearMiss(Step& step, const StepContact& contact)
{
	if (!rebounds(step, contact, 0) && (contact.count == 1 || !rebounds(step, contact, 1)))
		return false;
	if (!hasLargeDisplacement(
	            step, contact, initial(step, contact.body1), initial(step, contact.body2)))
		return false;
	double least[2] = { infinity, infinity };
	for (int sample = 1; sample <= nearMissSamples; ++sample) {
		const Manifold now = pointsAfter(step, contact, step.dt * sample / nearMissSamples,
		        [&](int id) { return initial(step, id); });
		for (int k = 0; k < contact.count; ++k)
			least[k] = std::min(least[k], gapOf(step, contact, k, now));
	}
	bool changed = false;
	for (int k = 0; k < contact.count; ++k) {
		ContactPoint& c   = step.problem.points[contact.first + k];
		const double  gap = step.gap[contact.first + k].atStart;
		const double  hit = std::min(0.0, gap) - clearance * contact.slop();
		if (!rebounds(step, contact, k) || least[k] < hit) continue;
		const double  closing = -step.initialVelocity(c).n;
		// the bodies keep their velocities
		c.bias  = std::max(gap, 0.0) / step.dt + closing;
		changed = true;
	}
	return changed;
}

} // namespace rcr

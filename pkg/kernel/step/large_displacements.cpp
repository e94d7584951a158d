#include "step/large_displacements.hpp"

#include <algorithm>

#include "step/missed_contacts.hpp"

namespace rcr {

namespace {

	constexpr double infinity  = std::numeric_limits<double>::infinity();
	constexpr int    looks     = 4;    // times within the step at which a gap is measured before its contact is let pass
	constexpr int    finerLooks = 8;   // the same where there is no plane to go on
	constexpr double clearance = 0.02; // share of the slop by which a gap must stay open: a push, unlike an overlap, is felt at once …
	constexpr double atWork    = 0.5;  // … but what bears has pushed before: it may lift by what a small displacement curves by
	constexpr double early     = 0.01; // of the way that it closes: what arrives so much too early arrives all the same

	const Twist& solved(const Step& step, int id) { return step.problem.velocity[id]; }
	const Twist& initial(const Step& step, int id) { return step.bodies[id].velocity; }

	/// As they are looked for at the beginning of a step: with a farther reach others could take their places.
	Manifold pointsAfter(const Step& step, const StepContact& c, double time, const Twist& (*velocity)(const Step&, int))
	{
		const auto at = [&](int id) {
			const StepBody& body = step.bodies[id];
			return moved(body, step.bodies[body.owner], velocity(step, body.owner), time);
		};
		Pose at2   = at(c.body2);
		at2.center = at2.center + c.shift + time * c.drift;
		return contactPoints(step.bodies[c.body1].shape, at(c.body1), step.bodies[c.body2].shape, at2, reachOf(step, c.body1) + reachOf(step, c.body2));
	}

	/// Gap of the point that was number k of `count`; the deepest where their number has changed. Behind a body it is no gap.
	double gapOf(const Manifold& now, int k, int count, Vec2 normal)
	{
		if (now.count == 0) return infinity;
		const int at = now.count == count ? k : now.count == 2 && now.points[1].gap < now.points[0].gap ? 1 : 0;
		return dot(now.points[at].normal, normal) > 0 ? now.points[at].gap : -infinity;
	}

	/// Decides whether a path that is clear of the other body at `time`, on its far side, crosses it or passes beside it.
	/// Bisection: beside a body the normal turns gradually, across it the normal flips.
	bool crosses(const Step& step, const StepContact& contact, double time, Vec2 normalBefore, Vec2 normalAfter)
	{
		constexpr int halvings = 10;
		double        before = 0, after = time;
		for (int k = 0; k < halvings; ++k) {
			const double   middle = 0.5 * (before + after);
			const Manifold at     = pointsAfter(step, contact, middle, solved);
			if (at.count == 0) return false;
			if (at.points[0].gap < 0) return true;
			const Vec2 normal = at.points[0].normal;
			if (dot(normal, normalBefore) < 0) after = middle, normalAfter = normal;
			else if (dot(normal, normalAfter) < 0)
				before = middle, normalBefore = normal;
			else
				return false;
		}
		return true;
	}

	/// The body has gone through the other one at `time`, whether it still overlaps it or not.
	bool through(const Step& step, const StepContact& contact, const Manifold& now, double time, Vec2 normal)
	{
		if (now.count == 0 || dot(now.points[0].normal, normal) > 0) return false;
		return now.points[0].gap < 0 || crosses(step, contact, time, normal, now.points[0].normal);
	}

} // namespace

bool adaptToDisplacement(Step& step, const StepContact& contact, bool letGo, double& overlap)
{
	const double dt = step.dt, slop = contact.slop();
	Manifold     at[looks];
	for (int look = 0; look < looks; ++look)
		at[look] = pointsAfter(step, contact, dt * (look + 1) / looks, solved);
	bool changed = false;
	for (int k = 0; k < contact.count; ++k) {
		const int     number = contact.first + k;
		ContactPoint& c      = step.problem.points[number];
		const double  gap    = step.gap[number].now;
		const double  way    = dt * relativeVelocity(c, step.problem.velocity[c.body1], step.problem.velocity[c.body2]).n;
		double        least  = infinity;
		for (const Manifold& now : at)
			least = std::min(least, gapOf(now, k, contact.count, c.normal));
		int last = looks; // look at which it is still on this side
		while (last > 0 && through(step, contact, at[last - 1], dt * last / looks, c.normal))
			--last;
		if (last == 0) { // no gap on this side is known: the step counts as not converged
			overlap = 1;
			continue;
		}
		const double share = double(last) / looks, end = gapOf(at[last - 1], k, contact.count, c.normal);
		if (std::isfinite(end)) overlap = std::max(overlap, -end / contact.size);
		const bool    sinks  = (end < std::min(0.0, gap) - slop || last < looks) && std::isfinite(end);
		const double  open   = contact.restitution > 0 ? clearance * slop : std::max((step.gap[number].carried ? atWork : clearance) * slop, -early * way);
		const bool    passes = letGo && step.problem.impulse[number].n > 0 && least > open && std::isfinite(least);
		if (contact.restitution > 0 && c.bias < 0) continue; // it bounces at the beginning of the step
		if (!sinks && !passes) continue;
		const double before = relativeVelocity(c, step.bodies[c.body1].velocity, step.bodies[c.body2].velocity).n;
		if (sinks && contact.restitution > 0 && before < 0 && c.bias > 0) { // it meets within the step, and its plane does not know
			c.bias  = contact.restitution * before;
			changed = true;
			continue;
		}
		const double curve  = sinks ? (end - gap - share * way) / (share * share) : 2 * least - gap - way; // 2: lets go where another one carries too
		const double bias   = std::max((std::max(gap, 0.0) + curve) / dt, std::min(0.0, before)); // no push beyond that of an elastic bounce
		if (dt * std::abs(bias - c.bias) < clearance * slop) continue; // what the tolerance of the solver leaves would come up again and again
		c.bias  = bias;
		changed = true;
	}
	return changed;
}

bool takeBackBounces(Step& step, const StepContact& contact)
{
	const auto bounces = [&](int k) { return step.problem.points[contact.first + k].bias < 0; };
	if (!(bounces(0) || (contact.count == 2 && bounces(1)))) return false;
	if (!displacesFar(step, contact, initial(step, contact.body1), initial(step, contact.body2))) return false;
	double least[2] = { infinity, infinity };
	for (int look = 1; look <= finerLooks; ++look) {
		const Manifold now = pointsAfter(step, contact, step.dt * look / finerLooks, initial);
		for (int k = 0; k < contact.count; ++k)
			least[k] = std::min(least[k], gapOf(now, k, contact.count, step.problem.points[contact.first + k].normal));
	}
	bool changed = false;
	for (int k = 0; k < contact.count; ++k) {
		ContactPoint& c   = step.problem.points[contact.first + k];
		const double  gap = step.gap[contact.first + k].now;
		if (!bounces(k) || least[k] < std::min(0.0, gap) - clearance * contact.slop()) continue;
		const double closing = -relativeVelocity(c, initial(step, c.body1), initial(step, c.body2)).n;
		c.bias               = std::max(gap, 0.0) / step.dt + closing; // it may go on as it is
		changed              = true;
	}
	return changed;
}

} // namespace rcr

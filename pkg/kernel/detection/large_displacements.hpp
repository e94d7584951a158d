// Contacts whose bodies pass each other or rotate far within one step.
//
// The law describes a contact by its tangent plane at the beginning of the step: g + dt u_n ≥ 0.
// The gap at the end differs from this by the curvature of the path, about λ²/2ρ for a relative
// displacement λ. A disc that passes a corner would be deflected by a plane that it never meets. A
// spinning rod would end inside a body. After a solve, the gap of a large displacement is
// therefore measured at four instants of the step. If it ends below min(0, g) by more than the
// slop, its difference c from the plane enters the bias. The step is then solved again:
//
//   g_end(v) = g + dt u_n + c  ⟹  b_n = (max(g, 0) + c)/dt
//
// The bias is at least min(0, u_n⁻), with the normal velocity u_n⁻ before the step. The contact
// then pushes no harder than an elastic impact. separation.hpp removes the remaining overlap.
//
// A loaded point whose gap stays open along the path is released. With the smallest measured gap
// g_min, its bias rises by 2 g_min/dt, and by |g|/dt at an overlap g < 0. The gap must exceed 2 %
// of the slop. Without restitution, it must also exceed min(slop, 1 % of the closing path), and
// half the slop if the contact bore a force before the step.
//
// A contact with restitution is released if the bodies would miss each other at their initial
// velocities. Quasi-static flow has no large displacements: its paths are 1e-3 radii per step.
//
// Four instants do not show all of a path: a thin grain may cut through another one between them.
// `intrudesOnPath` is exact. It advances in time by conservative steps, in which the gap along the
// present normal cannot close. Source: Mirtich 1996 (conservative advancement).
#pragma once

#include "detection/late_contacts.hpp"

namespace rcr {

/// Relative displacement λ per step over √((R₁ + R₂) ρ) [-] at which the deviation λ²/2ρ from the
/// tangent plane is half the slop. ρ is the sum of the inscribed radii, R₁' + R₂' of two stadia.
constexpr double largeDisplacement = 0.01;

/// Sum ρ of the inscribed radii of two bodies [m]; that of an obstacle is 0.
inline double inscribedRadii(const Step& step, const StepContact& c)
{
	const auto of = [&](const PlanarShape& s) { return s.grain() ? s.inscribedRadius() : 0; };
	return of(step.bodies[c.body1].shape) + of(step.bodies[c.body2].shape);
}

/// Upper bound of the path of a point of one body relative to the other by their rotations in the
/// step [m].
inline double rotationPath(
        const Step& step, const StepContact& c, const PlanarVector& v1, const PlanarVector& v2)
{
	return step.pathOf(c.body1, { 0, 0, v1.rotation }) + step.pathOf(c.body2, { 0, 0, v2.rotation });
}

/// Translation of body 2 relative to body 1 in the step [m].
inline Vec2 relativeShift(
        const Step& step, const StepContact& c, const PlanarVector& v1, const PlanarVector& v2)
{
	return step.dt * Vec2 { v2.x + c.drift.x - v1.x, v2.y + c.drift.y - v1.y };
}

/// Returns true if the contact has a large displacement at these velocities of its bodies.
inline bool hasLargeDisplacement(
        const Step& step, const StepContact& c, const PlanarVector& v1, const PlanarVector& v2)
{
	const double path = norm(relativeShift(step, c, v1, v2)) + rotationPath(step, c, v1, v2);
	return path * path > largeDisplacement * largeDisplacement * c.size * inscribedRadii(step, c);
}

/// At the solved velocities.
inline bool hasLargeDisplacement(const Step& step, const StepContact& c)
{
	return hasLargeDisplacement(
	        step, c, step.problem.velocity[c.body1], step.problem.velocity[c.body2]);
}

/// Returns true if a contact has a large displacement at the solved velocities.
inline bool anyLargeDisplacement(const Step& step)
{
	return std::any_of(step.contacts.begin(), step.contacts.end(),
	        [&](const StepContact& contact) { return hasLargeDisplacement(step, contact); });
}

/// Contact points of the bodies after `time` with gaps up to `maxGap`. velocityOf(id) returns the
/// velocity of a body.
template <class VelocityOf>
Manifold pointsAfter(const Step& step, const StepContact& c, double time, VelocityOf velocityOf,
        double maxGap)
{
	const auto at = [&](int id) {
		const StepBody& body = step.bodies[id];
		return poseAfter(body, step.bodies[body.owner], velocityOf(body.owner), time);
	};
	Pose at2   = at(c.body2);
	at2.center = at2.center + c.shift + time * c.drift;
	return contactPoints(step.bodies[c.body1].shape, at(c.body1), step.bodies[c.body2].shape, at2,
	        maxGap);
}

/// Contact points within the detection reach of the bodies.
template <class VelocityOf>
Manifold pointsAfter(const Step& step, const StepContact& c, double time, VelocityOf velocityOf)
{
	return pointsAfter(step, c, time, velocityOf,
	        detectionReach(step, c.body1) + detectionReach(step, c.body2));
}

/// Contact points after `time` at the solved velocities.
Manifold solvedPointsAfter(const Step&, const StepContact&, double time);

/// Returns true if a body has passed through the other one at `time`, when the contact points are
/// `now`. Otherwise it is on its original side, out of reach, or has moved around. Bisection in
/// time finds the change of the normal: it is continuous around a body and jumps through it.
/// `normalBefore`: contact normal at the beginning of the step.
bool passedThrough(const Step&, const StepContact&, Vec2 normalBefore, const Manifold& now,
        double time);

/// Returns true if at some instant of the step, at the solved velocities, the overlap exceeds the
/// smaller inscribed radius; at an obstacle that of the grain. Thin grains then cross.
/// Bodies whose overlap is as deep at the beginning do not count.
bool intrudesOnPath(const Step&, const StepContact&);

/// Returns true if the bodies meet on their paths at the solved velocities: the overlap exceeds the
/// slop at one of four instants, or the bodies intrude on their paths.
bool meetOnPaths(const Step&, const StepContact&);

/// Enters the gaps along the paths into the biases of the contact. Returns true if a bias changed.
/// `allowRelease`: a point whose gap stays open along the path may be released.
bool adaptToDisplacement(Step&, const StepContact&, bool allowRelease);

/// Releases a contact with restitution whose bodies do not meet at their initial velocities. The
/// bodies then keep these velocities. Returns true if a bias changed.
bool releaseNearMiss(Step&, const StepContact&);

} // namespace rcr

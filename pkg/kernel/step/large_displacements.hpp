// Bodies that pass each other or turn by much within one step.
//
// The law of a step knows each contact by the plane of its beginning: g + dt u_n ≥ 0. The gap in which a solution really ends differs
// from that by the curvature of the way, some s²/2ρ for a relative way s. A disc that flies past a corner is thus deflected by a
// plane that it never meets, and a spinning rod ends inside what it sweeps along. Where the way is long, the gap is measured at the
// moved positions, and its difference to the plane's goes into the bias for the step to be solved once more:
//
//   g_end(v) = g + dt u_n + c  ⟹  b_n = (max(g, 0) + c)/dt
//
// but no push beyond that of an elastic bounce, b_n ≥ min(0, u_n⁻): a contact may have other points there, and an old overlap.
//
// A contact that the way passes is let go: the push on it is felt at once, so a gap of a fiftieth of the slop counts. One that has carried a
// force already is no such contact. It rests, and may lift by half the slop: what a displacement curves by that is not looked at. Nor is one
// that closes all but a hundredth of its way: it arrives, in this step or the next. With restitution both are let go all the same: a contact that
// holds what should bounce takes its energy.
//
// A bounce is decided by the same plane. Where the way is long, it is taken back if the bodies do not meet on their ways at the velocities of
// the beginning.
//
// Quasi-static flow never comes here: its ways are a thousandth of a radius a step.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Relative way s in a step over √((R₁ + R₂) ρ) [-] whose curvature, s²/2ρ, may exceed the slop; ρ = R₁' + R₂', of caps and corners.
constexpr double largeDisplacement = 0.01;

/// Has a contact a large displacement, with these velocities of its bodies?
inline bool displacesFar(const Step& step, const StepContact& c, const Twist& v1, const Twist& v2)
{
	const StepBody &  one = step.bodies[c.body1], &two = step.bodies[c.body2];
	const double      translation = norm(Vec2 { v2.x + c.drift.x - v1.x, v2.y + c.drift.y - v1.y });
	const auto        cap         = [](const StepBody& b) { return b.shape.grain() ? b.shape.halfWidth : 0; };
	const double      way         = step.dt * (translation + std::abs(v1.rotation) * one.radius + std::abs(v2.rotation) * two.radius);
	return way * way > largeDisplacement * largeDisplacement * c.size * (cap(one) + cap(two));
}

/// The same of the solved step: nearly none has.
inline bool displacesFar(const Step& step, const StepContact& c) { return displacesFar(step, c, step.problem.velocity[c.body1], step.problem.velocity[c.body2]); }

/// Puts the gap in which such a contact really ends into its biases; true if one has changed. Contacts that the way passes are let
/// go only where `letGo` says so: what is let go may sink in. The deepest overlap at the end of the step is kept in `overlap`, over
/// R₁ + R₂ [-].
bool adaptToDisplacement(Step&, const StepContact&, bool letGo, double& overlap);

/// Of a contact with restitution: takes back bounces off planes that bodies pass: on their ways at the velocities of the beginning they do not meet. True if there was one.
bool takeBackBounces(Step&, const StepContact&);

} // namespace rcr

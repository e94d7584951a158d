// How a body in the plane moves on: the leapfrog of YADE's NewtonIntegrator, to the last bit.
//
//   v ← v + dt (f/m + g)      x ← x + dt v      θ ← θ + dt ω, as a quaternion that is scaled to length 1
#pragma once

#include <cmath>

#include "step/step.hpp"

namespace rcr {

/// What resists a body's acceleration, and which of its degrees of freedom are free.
struct Inertia {
	double mass = 0, moment = 0; // [kg, kg m²]
	bool   x = false, y = false, rotation = false;
};

/// The velocity at the end of a step under a force and a torque [N, N m] and gravity [m/s²].
inline Twist accelerated(Twist v, const Inertia& inertia, const Twist& force, Vec2 gravity, double dt)
{
	if (inertia.x) v.x += dt * (force.x / inertia.mass + gravity.x);
	if (inertia.y) v.y += dt * (force.y / inertia.mass + gravity.y);
	if (inertia.rotation) v.rotation += dt * (force.rotation / inertia.moment);
	return v;
}

/// The velocity of a body without inertia at the beginning of a step: that of rest, and what is prescribed.
inline Twist atRest(Twist v, const Inertia& inertia, const Twist& rest)
{
	if (inertia.x) v.x = rest.x;
	if (inertia.y) v.y = rest.y;
	if (inertia.rotation) v.rotation = rest.rotation;
	return v;
}

/// The turn after the time dt with an angular velocity.
inline Turn leapt(const Turn& turn, double rotation, double dt) { return scaled(rotation != 0 ? turned(turn, rotation * dt) : turn); }

} // namespace rcr

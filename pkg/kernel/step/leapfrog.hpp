// Leapfrog integration of a body in the plane, with the same bits as YADE's NewtonIntegrator.
//
//   v ← v + dt (f/m + g)      x ← x + dt v      θ ← θ + dt ω, as a quaternion of length 1
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Mass and moment of inertia of a body, and its free degrees of freedom.
struct Inertia {
	double mass = 0, moment = 0; // [kg, kg m²]
	bool   x = false, y = false, rotation = false;
};

/// Velocity at the end of a step under a force and a torque [N, N m] and gravity [m/s²].
inline Twist accelerated(
        Twist v, const Inertia& inertia, const Twist& force, Vec2 gravity, double dt)
{
	if (inertia.x) v.x += dt * (force.x / inertia.mass + gravity.x);
	if (inertia.y) v.y += dt * (force.y / inertia.mass + gravity.y);
	if (inertia.rotation) v.rotation += dt * (force.rotation / inertia.moment);
	return v;
}

/// Velocity of an overdamped body at the beginning of a step: `start` in its free degrees of
/// freedom.
inline Twist startVelocity(Twist v, const Inertia& inertia, const Twist& start)
{
	if (inertia.x) v.x = start.x;
	if (inertia.y) v.y = start.y;
	if (inertia.rotation) v.rotation = start.rotation;
	return v;
}

/// Rotation after the time dt at an angular velocity [rad/s].
inline Turn turnAfter(const Turn& turn, double rotation, double dt)
{
	return normalized(rotation != 0 ? turned(turn, rotation * dt) : turn);
}

} // namespace rcr

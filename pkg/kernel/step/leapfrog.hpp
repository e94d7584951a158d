// Leapfrog integration of a body in the plane, with the same bits as YADE's NewtonIntegrator.
//
//   v ← v + dt (f/m + g)      x ← x + dt v      θ ← θ + dt ω, as a quaternion of length 1
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Mass and moment of inertia of a body, and which of its degrees of freedom are free.
struct Inertia {
	double mass = 0, moment = 0; // [kg, kg m²]
	bool   freeX = false, freeY = false, freeRotation = false;
};

/// Velocity at the end of a step under a force and a torque [N, N m] and gravity [m/s²].
inline PlanarVector accelerated(
        PlanarVector v, const Inertia& inertia, const PlanarVector& force, Vec2 gravity, double dt)
{
	if (inertia.freeX) v.x += dt * (force.x / inertia.mass + gravity.x);
	if (inertia.freeY) v.y += dt * (force.y / inertia.mass + gravity.y);
	if (inertia.freeRotation) v.rotation += dt * (force.rotation / inertia.moment);
	return v;
}

/// Velocity of an overdamped body at the beginning of a step: `start` in its free degrees of
/// freedom.
inline PlanarVector startVelocity(PlanarVector v, const Inertia& inertia, const PlanarVector& start)
{
	if (inertia.freeX) v.x = start.x;
	if (inertia.freeY) v.y = start.y;
	if (inertia.freeRotation) v.rotation = start.rotation;
	return v;
}

/// Rotation after the time dt at an angular velocity [rad/s].
inline Turn turnAfter(const Turn& turn, double rotation, double dt)
{
	return normalized(rotation != 0 ? turned(turn, rotation * dt) : turn);
}

/// Displaces a body by a position correction; its velocity stays.
inline void displace(StepBody& body, const PlanarVector& by)
{
	body.center = { body.center.x + by.x, body.center.y + by.y };
	if (by.rotation != 0) body.turn = normalized(turned(body.turn, by.rotation));
}

/// Moves a body by its velocity for the time dt [s].
inline void move(StepBody& body, double dt)
{
	const PlanarVector& v = body.velocity;
	body.center           = { body.center.x + v.x * dt, body.center.y + v.y * dt };
	body.turn             = turnAfter(body.turn, v.rotation, dt);
}

} // namespace rcr

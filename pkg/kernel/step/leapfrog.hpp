// Leapfrog integration of a body in the plane, with the same bits as YADE's NewtonIntegrator.
//
//   v ← v + dt (f/m + g)      x ← x + dt v      θ ← θ + dt ω, as a quaternion of length 1
//
// A periodic cell also adds dt G v + ΔG x to v, with its gradient G of the last step and the change
// ΔG of the gradient. Members of a clump keep their pose in its frame.
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

/// `accelerated` in a periodic cell. The flow of the cell also acts on prescribed motion. `free`:
/// StepBody::free.
inline PlanarVector acceleratedInCell(PlanarVector v, const Inertia& inertia, bool free,
        const PlanarVector& force, Vec2 gravity, double dt, const PeriodicCell& cell, Vec2 center)
{
	const auto& g = cell.convection.gradient;
	if (free) {
		const Vec2 turned = product(g, { v.x, v.y });
		v.x += dt * ((inertia.freeX ? force.x / inertia.mass + gravity.x : 0) + turned.x);
		v.y += dt * ((inertia.freeY ? force.y / inertia.mass + gravity.y : 0) + turned.y);
		if (inertia.freeRotation) v.rotation += dt * (force.rotation / inertia.moment);
	} else {
		const double scaled[2][2] { { dt * g[0][0], dt * g[0][1] }, { dt * g[1][0], dt * g[1][1] } };
		const Vec2   change = product(scaled, { v.x, v.y });
		v.x += change.x, v.y += change.y;
	}
	return v + cell.change.at(center);
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
	body.turn = normalized(v.rotation != 0 ? turned(body.turn, v.rotation * dt) : body.turn);
}

/// Pose of a clump member in the frame of its clump.
struct ClumpMember {
	std::int32_t id = 0;
	Vec2         place;
	Turn         turn;
};

/// Moves a clump member with its clump.
inline void moveMember(StepBody& body, const ClumpMember& member, const StepBody& clump)
{
	const Turn &      t = clump.turn, &own = member.turn;
	const Vec2        r = member.place, twice = 2.0 * Vec2 { -t.z * r.y, t.z * r.x };
	body.center = { clump.center.x + (r.x + t.w * twice.x - t.z * twice.y),
		clump.center.y + (r.y + t.w * twice.y + t.z * twice.x) };
	body.turn     = { t.w * own.w - t.z * own.z, t.w * own.z + t.z * own.w };
	body.velocity = memberVelocity(body, clump.center, clump.velocity);
}

/// Sets velocity and free velocity of a body at the beginning of a step, under a force and
/// gravity. `end`: its velocity at the end of the last step.
inline void beginStep(Step& step, std::size_t id, const PlanarVector& end, const Inertia& inertia,
        const PlanarVector& force, Vec2 gravity)
{
	StepBody&     body = step.bodies[id];
	PlanarVector& v    = body.velocity;
	v = step.overdamped ? startVelocity(end, inertia, step.startFlow.at(body.center)) : end;
	if (step.cell.periodic) v = v + step.cell.change.at(body.center);
	body.velocityBefore = v;
	PlanarVector& free = step.problem.freeVelocity[id];
	free               = accelerated(v, inertia, force, gravity, step.dt);
	if (!step.cell.periodic) return;
	body.convection = step.dt * product(step.cell.convection.gradient, { end.x, end.y });
	free            = free + PlanarVector { body.convection.x, body.convection.y, 0 };
}

/// Returns true if a body of this velocity moves along a prescribed axis.
inline bool isDriven(const InverseMass& mass, const PlanarVector& v)
{
	return (mass.x == 0 && v.x != 0) || (mass.y == 0 && v.y != 0)
	        || (mass.rotation == 0 && v.rotation != 0);
}

/// A body of prescribed motion, and its Step::initialVelocity.
struct Drive {
	int          body = -1;
	PlanarVector velocity;
};

/// The bodies that move along a prescribed axis in this step.
inline std::vector<Drive> drivesOf(const Step& step)
{
	std::vector<Drive> found;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const InverseMass& mass = step.problem.inverseMass[id];
		if (mass.x != 0 && mass.y != 0 && mass.rotation != 0) continue; // free: the usual case
		const PlanarVector v = step.initialVelocity(int(id));
		if (isDriven(mass, v)) found.push_back({ int(id), v });
	}
	return found;
}

/// After beginStep: prescribed axes of a body that was driven in the step before get the velocity
/// for impacts that they would have without the acceleration of the drive. `before`: of that step.
inline void setDriveBefore(Step& step, const Drive& before)
{
	const InverseMass& mass = step.problem.inverseMass[before.body];
	if (!isDriven(mass, before.velocity)) return;
	StepBody&          body  = step.bodies[before.body];
	PlanarVector&      v     = body.velocityBefore;
	const PlanarVector drive = before.velocity + step.cell.change.at(body.center);
	if (mass.x == 0) v.x = drive.x;
	if (mass.y == 0) v.y = drive.y;
	if (mass.rotation == 0) v.rotation = drive.rotation;
}

} // namespace rcr

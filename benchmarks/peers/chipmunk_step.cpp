// Steps a packing in Chipmunk. A grain is a segment with a radius, a rounded-cap rectangle.
#include <chipmunk/chipmunk.h>
#include <chipmunk/chipmunk_structs.h> // declares the impulses of single points

#include <cmath>
#include <cstdint>

#include "packing.hpp"

namespace {

constexpr cpGroup wallGroup = 1; // shapes of a group do not collide

cpBody* add(cpSpace* space, const BodyRow& row, double friction, int id)
{
	const bool free = row.mass > 0;
	cpBody*    body = cpSpaceAddBody(space, free ? cpBodyNew(row.mass, row.isGrain() ? row.inertia : INFINITY) : cpBodyNewKinematic());
	cpBodySetPosition(body, cpv(row.x, row.y));
	cpBodySetAngle(body, row.angle);
	cpBodySetVelocity(body, cpv(row.vx, row.vy));
	cpBodySetAngularVelocity(body, row.omega);
	cpBodySetUserData(body, reinterpret_cast<cpDataPointer>(static_cast<std::intptr_t>(id)));
	cpShape* shape;
	if (row.isGrain()) {
		const cpVect end  = cpv(row.halfLength, 0);
		const bool   disc = row.halfLength == 0;
		shape             = disc ? cpCircleShapeNew(body, row.radius, cpvzero) : cpSegmentShapeNew(body, cpvneg(end), end, row.radius);
		cpShapeSetFriction(shape, std::sqrt(friction)); // Chipmunk multiplies the values of both shapes
	} else {
		const cpVect normal = cpv(row.normalX, row.normalY), along = cpvmult(cpvperp(normal), wallHalfLength);
		const cpVect middle = cpvmult(normal, -wallThickness / 2);
		shape               = cpSegmentShapeNew(body, cpvsub(middle, along), cpvadd(middle, along), wallThickness / 2);
		cpShapeSetFriction(shape, 0);
		cpShapeSetFilter(shape, cpShapeFilterNew(wallGroup, CP_ALL_CATEGORIES, CP_ALL_CATEGORIES));
	}
	cpSpaceAddShape(space, shape);
	return body;
}

int idOf(const cpBody* body) { return static_cast<int>(reinterpret_cast<std::intptr_t>(cpBodyGetUserData(body))); }

/// Adds the contacts in which the body is the first; each contact is listed once.
void list(cpBody* body, cpArbiter* arbiter, void* data)
{
	if (arbiter->body_a != body) return;
	auto& contacts = *static_cast<std::vector<ContactRow>*>(data);
	for (int k = 0; k < arbiter->count; ++k) {
		const cpContact& c = arbiter->contacts[k];
		contacts.push_back({ idOf(arbiter->body_a), idOf(arbiter->body_b), arbiter->n.x, arbiter->n.y, c.r1.x, c.r1.y, c.r2.x, c.r2.y, arbiter->u,
		                     c.jnAcc, c.jtAcc, NAN });
	}
}

std::vector<Velocity> velocities(const std::vector<cpBody*>& bodies)
{
	std::vector<Velocity> result;
	for (const cpBody* b : bodies)
		result.push_back({ cpBodyGetVelocity(b).x, cpBodyGetVelocity(b).y, cpBodyGetAngularVelocity(b) });
	return result;
}

Outcome run(const Task& task)
{
	cpSpace* space = cpSpaceNew();
	cpSpaceSetIterations(space, task.iterations);
	cpSpaceSetCollisionSlop(space, task.slop);
	cpSpaceSetCollisionPersistence(space, 1); // a cached contact would return an impulse that was not applied
	std::vector<cpBody*> bodies;
	for (const BodyRow& row : task.bodies)
		bodies.push_back(add(space, row, task.friction, int(bodies.size())));

	Outcome outcome { std::string("Chipmunk ") + cpVersionString, {}, {}, {}, {} };
	for (int step = 0; step < task.steps; ++step) {
		for (std::size_t i = 0; i < bodies.size(); ++i)
			if (task.bodies[i].mass > 0) cpBodySetForce(bodies[i], cpv(task.bodies[i].fx, task.bodies[i].fy));
		outcome.before = velocities(bodies);
		outcome.seconds.push_back(secondsOf([&] { cpSpaceStep(space, task.dt); }));
	}
	outcome.after = velocities(bodies);
	for (cpBody* body : bodies)
		cpBodyEachArbiter(body, list, &outcome.contacts);
	for (ContactRow& c : outcome.contacts) { // at the positions of the contact detection
		const cpVect x1 = cpBodyGetPosition(bodies[c.body1]), x2 = cpBodyGetPosition(bodies[c.body2]);
		c.gap           = cpvdot(cpvsub(cpvadd(x2, cpv(c.r2x, c.r2y)), cpvadd(x1, cpv(c.r1x, c.r1y))), cpv(c.nx, c.ny));
	}
	return outcome;
}

} // namespace

int main(int argc, char** argv) { return stepProgram(argc, argv, run); }

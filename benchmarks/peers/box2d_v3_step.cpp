// Steps a packing in Box2D 3. A grain is a capsule, a disc is a circle. An iteration is a substep.
//
// Box2D sums the normal impulses of the substeps, but not those of friction. Impulses are therefore
// complete with one substep only.
#include <box2d/box2d.h>

#include <cfloat>
#include <cmath>

#include "packing.hpp"

namespace {

b2Vec2 vect(double x, double y) { return { float(x), float(y) }; }

int idOf(b2ShapeId shape)
{
	return int(reinterpret_cast<std::intptr_t>(b2Body_GetUserData(b2Shape_GetBody(shape))));
}

b2ShapeDef material(double friction, int group)
{
	b2ShapeDef shape         = b2DefaultShapeDef();
	shape.material.friction  = float(friction);
	shape.filter.groupIndex  = group;
	shape.updateBodyMass     = false;
	shape.enableSensorEvents = shape.enableContactEvents = false;
	return shape;
}

void addGrain(b2BodyId body, const BodyRow& row, double friction)
{
	const b2ShapeDef shape   = material(friction, 0);
	const b2Capsule  capsule { vect(-row.halfLength, 0), vect(row.halfLength, 0), float(row.radius) };
	const b2Circle   circle { b2Vec2_zero, float(row.radius) };
	if (row.halfLength > 0) b2CreateCapsuleShape(body, &shape, &capsule);
	else
		b2CreateCircleShape(body, &shape, &circle);
}

void addWall(b2BodyId body, const BodyRow& row)
{
	const b2ShapeDef shape = material(0, -1); // bodies of a negative group do not collide: walls
	const b2Polygon  slab  = b2MakeOffsetBox(float(wallThickness / 2), float(wallHalfLength),
            vect(-wallThickness / 2 * row.normalX, -wallThickness / 2 * row.normalY),
            b2MakeRot(float(std::atan2(row.normalY, row.normalX))));
	b2CreatePolygonShape(body, &shape, &slab);
}

b2BodyId add(b2WorldId world, const BodyRow& row, double friction, int id)
{
	b2BodyDef definition            = b2DefaultBodyDef();
	definition.type                 = row.mass > 0 ? b2_dynamicBody : b2_kinematicBody;
	definition.position             = { float(row.x), float(row.y) };
	definition.rotation             = b2MakeRot(float(row.angle));
	definition.linearVelocity       = vect(row.vx, row.vy);
	definition.angularVelocity      = float(row.omega);
	definition.motionLocks.angularZ = !row.isGrain();
	definition.enableSleep          = false;
	definition.userData             = reinterpret_cast<void*>(std::intptr_t(id));
	const b2BodyId body             = b2CreateBody(world, &definition);
	if (row.isGrain()) addGrain(body, row, friction);
	else
		addWall(body, row);
	const b2MassData mass { float(row.mass), b2Vec2_zero, row.isGrain() ? float(row.inertia) : 1 };
	if (row.mass > 0) b2Body_SetMassData(body, mass);
	return body;
}

/// Contacts of the last step.
std::vector<ContactRow> contactRows(const std::vector<b2BodyId>& bodies)
{
	std::vector<ContactRow> rows;
	for (std::size_t id = 0; id < bodies.size(); ++id) {
		std::vector<b2ContactData> contacts(b2Body_GetContactCapacity(bodies[id]));
		contacts.resize(b2Body_GetContactData(bodies[id], contacts.data(), int(contacts.size())));
		for (const b2ContactData& contact : contacts) {
			const int         one = idOf(contact.shapeIdA), two = idOf(contact.shapeIdB);
			const b2Manifold& m = contact.manifold;
			if (one != int(id)) continue; // it comes with the other body
			const double friction = std::sqrt(b2Shape_GetFriction(contact.shapeIdA)
			        * b2Shape_GetFriction(contact.shapeIdB)); // the rule of Box2D
			for (int k = 0; k < m.pointCount; ++k) {
				const b2ManifoldPoint& p = m.points[k];
				rows.push_back({ one, two, m.normal.x, m.normal.y, p.anchorA.x, p.anchorA.y,
				        p.anchorB.x, p.anchorB.y, friction, p.totalNormalImpulse,
				        -p.tangentImpulse, p.separation }); // its tangent: normal turned by −90°
			}
		}
	}
	return rows;
}

std::vector<Velocity> velocities(const std::vector<b2BodyId>& bodies)
{
	std::vector<Velocity> result;
	for (const b2BodyId b : bodies) {
		const b2Vec2 v = b2Body_GetLinearVelocity(b);
		result.push_back({ v.x, v.y, b2Body_GetAngularVelocity(b) });
	}
	return result;
}

Outcome run(const Task& task)
{
	b2WorldDef definition         = b2DefaultWorldDef();
	definition.gravity            = b2Vec2_zero;
	definition.enableSleep        = false;
	definition.enableContinuous   = false;
	definition.maximumLinearSpeed = FLT_MAX;
	const b2WorldId       world   = b2CreateWorld(&definition);
	std::vector<b2BodyId> bodies;
	for (const BodyRow& row : task.bodies)
		bodies.push_back(add(world, row, task.friction, int(bodies.size())));

	const b2Version version = b2GetVersion();
	char            name[32];
	std::snprintf(
	        name, sizeof name, "Box2D %d.%d.%d", version.major, version.minor, version.revision);
	Outcome outcome { name, {}, {}, {}, {} };
	for (int step = 0; step < task.steps; ++step) {
		for (std::size_t i = 0; i < bodies.size(); ++i)
			if (task.bodies[i].mass > 0)
				b2Body_ApplyForceToCenter(
				        bodies[i], vect(task.bodies[i].fx, task.bodies[i].fy), true);
		outcome.before = velocities(bodies);
		outcome.seconds.push_back(
		        secondsOf([&] { b2World_Step(world, float(task.dt), task.iterations); }));
	}
	outcome.after    = velocities(bodies);
	outcome.contacts = contactRows(bodies);
	outcome.complete = task.iterations == 1;
	b2DestroyWorld(world);
	return outcome;
}

} // namespace

int main(int argc, char** argv) { return stepProgram(argc, argv, run); }

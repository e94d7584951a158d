// Steps a packing in Box2D 2.4. A grain is a rectangle with two circles, a disc is one circle.
#include <box2d/box2d.h>

#include <cmath>

#include "packing.hpp"

namespace {

constexpr int positionIterations = 3; // as its manual suggests

b2Vec2 vect(double x, double y) { return { float(x), float(y) }; }

void addFixture(b2Body* body, const b2Shape& shape, double friction, int group)
{
	b2FixtureDef fixture;
	fixture.shape             = &shape;
	fixture.friction          = float(friction);
	fixture.filter.groupIndex = int16(group);
	body->CreateFixture(&fixture);
}

void addGrain(b2Body* body, const BodyRow& row, double friction)
{
	b2CircleShape circle;
	circle.m_radius = float(row.radius);
	for (const double end : { -row.halfLength, row.halfLength }) {
		circle.m_p = vect(end, 0);
		addFixture(body, circle, friction, 0);
		if (row.halfLength == 0) return;
	}
	b2PolygonShape rectangle; // its skin b2_polygonRadius adds the rest
	rectangle.SetAsBox(float(row.halfLength), float(row.radius) - b2_polygonRadius);
	addFixture(body, rectangle, friction, 0);
}

void addWall(b2Body* body, const BodyRow& row)
{
	const double   depth = wallThickness / 2 + b2_polygonRadius;
	b2PolygonShape slab;
	const double   angle = std::atan2(row.normalY, row.normalX);
	slab.SetAsBox(float(wallThickness / 2), float(wallHalfLength), vect(-depth * row.normalX, -depth * row.normalY), float(angle));
	addFixture(body, slab, 0, -1); // bodies of a negative group do not collide: walls
}

b2Body* add(b2World& world, const BodyRow& row, double friction, int id)
{
	b2BodyDef definition;
	definition.type             = row.mass > 0 ? b2_dynamicBody : b2_kinematicBody;
	definition.position         = vect(row.x, row.y);
	definition.angle            = float(row.angle);
	definition.linearVelocity   = vect(row.vx, row.vy);
	definition.angularVelocity  = float(row.omega);
	definition.fixedRotation    = !row.isGrain();
	definition.allowSleep       = false;
	definition.userData.pointer = id;
	b2Body* body                = world.CreateBody(&definition);
	if (row.isGrain()) addGrain(body, row, friction);
	else
		addWall(body, row);
	const b2MassData mass { float(row.mass), b2Vec2_zero, row.isGrain() ? float(row.inertia) : 0 };
	if (row.mass > 0) body->SetMassData(&mass);
	return body;
}

/// Contacts of the last step: a manifold has its geometry, by the places before it, and its impulses.
std::vector<ContactRow> contactRows(b2World& world, const std::vector<b2Transform>& places)
{
	const auto              idOf = [](b2Fixture* fixture) { return int(fixture->GetBody()->GetUserData().pointer); };
	std::vector<ContactRow> rows;
	for (b2Contact* contact = world.GetContactList(); contact; contact = contact->GetNext()) {
		b2Fixture *       fixture1 = contact->GetFixtureA(), *fixture2 = contact->GetFixtureB();
		const int         b1 = idOf(fixture1), b2 = idOf(fixture2);
		const b2Manifold& manifold = *contact->GetManifold();
		b2WorldManifold   m;
		m.Initialize(&manifold, places[b1], fixture1->GetShape()->m_radius, places[b2], fixture2->GetShape()->m_radius);
		for (int k = 0; k < manifold.pointCount; ++k) {
			const b2ManifoldPoint& impulse = manifold.points[k];
			const b2Vec2           r1 = m.points[k] - places[b1].p, r2 = m.points[k] - places[b2].p;
			rows.push_back({ b1, b2, m.normal.x, m.normal.y, r1.x, r1.y, r2.x, r2.y, contact->GetFriction(), impulse.normalImpulse, -impulse.tangentImpulse,
			                 m.separations[k] }); // its tangent: normal turned by −90°
		}
	}
	return rows;
}

std::vector<Velocity> velocities(const std::vector<b2Body*>& bodies)
{
	std::vector<Velocity> result;
	for (const b2Body* b : bodies)
		result.push_back({ b->GetLinearVelocity().x, b->GetLinearVelocity().y, b->GetAngularVelocity() });
	return result;
}

Outcome run(const Task& task)
{
	b2World world(b2Vec2_zero);
	world.SetContinuousPhysics(false);
	std::vector<b2Body*> bodies;
	for (const BodyRow& row : task.bodies)
		bodies.push_back(add(world, row, task.friction, int(bodies.size())));

	char name[32];
	std::snprintf(name, sizeof name, "Box2D %d.%d.%d", b2_version.major, b2_version.minor, b2_version.revision);
	Outcome                  outcome { name, {}, {}, {}, {} };
	std::vector<b2Transform> places(bodies.size());
	for (int step = 0; step < task.steps; ++step) {
		for (std::size_t i = 0; i < bodies.size(); ++i) {
			places[i] = bodies[i]->GetTransform();
			if (task.bodies[i].mass > 0) bodies[i]->ApplyForceToCenter(vect(task.bodies[i].fx, task.bodies[i].fy), true);
		}
		outcome.before = velocities(bodies);
		outcome.seconds.push_back(secondsOf([&] { world.Step(float(task.dt), task.iterations, positionIterations); }));
	}
	outcome.after    = velocities(bodies);
	outcome.contacts = contactRows(world, places);
	return outcome;
}

} // namespace

int main(int argc, char** argv) { return stepProgram(argc, argv, run); }

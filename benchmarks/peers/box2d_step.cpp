// Steps a packing in Box2D 2.4. A grain is a rectangle with two circles, a disc is one circle.
#include <box2d/box2d.h>

#include <cmath>
#include <map>

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

/// Contacts of one step: geometry before the step, impulses after it.
class Listener : public b2ContactListener {
public:
	explicit Listener(const std::vector<b2Body*>& bodies)
	{
		for (const b2Body* body : bodies)
			centre_.push_back(body->GetPosition());
	}

	void PreSolve(b2Contact* contact, const b2Manifold*) override { contact->GetWorldManifold(&touching_[contact]); }

	void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override
	{
		const b2WorldManifold& m  = touching_.at(contact);
		const int              b1 = id(contact->GetFixtureA()), b2 = id(contact->GetFixtureB());
		for (int k = 0; k < impulse->count; ++k) {
			const b2Vec2 r1 = m.points[k] - centre_[b1], r2 = m.points[k] - centre_[b2];
			contacts.push_back({ b1, b2, m.normal.x, m.normal.y, r1.x, r1.y, r2.x, r2.y, contact->GetFriction(), impulse->normalImpulses[k],
			                     -impulse->tangentImpulses[k], m.separations[k] }); // its tangent: normal turned by −90°
		}
	}

	std::vector<ContactRow> contacts;

private:
	static int id(b2Fixture* fixture) { return int(fixture->GetBody()->GetUserData().pointer); }

	std::vector<b2Vec2>                   centre_;
	std::map<b2Contact*, b2WorldManifold> touching_;
};

std::vector<Velocity> velocities(const std::vector<b2Body*>& bodies)
{
	std::vector<Velocity> result;
	for (const b2Body* b : bodies)
		result.push_back({ b->GetLinearVelocity().x, b->GetLinearVelocity().y, b->GetAngularVelocity() });
	return result;
}

class Simulation {
public:
	explicit Simulation(const Task& task) : task_(task), world_(b2Vec2_zero)
	{
		world_.SetContinuousPhysics(false);
		for (const BodyRow& row : task.bodies)
			bodies.push_back(add(world_, row, task.friction, int(bodies.size())));
	}

	void step()
	{
		for (std::size_t i = 0; i < bodies.size(); ++i)
			if (task_.bodies[i].mass > 0) bodies[i]->ApplyForceToCenter(vect(task_.bodies[i].fx, task_.bodies[i].fy), true);
		world_.Step(float(task_.dt), task_.iterations, positionIterations);
	}

	void listen(b2ContactListener& listener) { world_.SetContactListener(&listener); }

	std::vector<b2Body*> bodies;

private:
	const Task& task_;
	b2World     world_;
};

Outcome run(const Task& task)
{
	char name[32];
	std::snprintf(name, sizeof name, "Box2D %d.%d.%d", b2_version.major, b2_version.minor, b2_version.revision);
	Outcome    outcome { name, {}, {}, {}, {} };
	Simulation timed(task), listed(task); // the listener costs time
	for (int k = 0; k < task.steps; ++k)
		outcome.seconds.push_back(secondsOf([&] { timed.step(); }));

	for (int k = 1; k < task.steps; ++k)
		listed.step();
	Listener listener(listed.bodies);
	listed.listen(listener);
	outcome.before = velocities(listed.bodies);
	listed.step();
	outcome.after    = velocities(listed.bodies);
	outcome.contacts = listener.contacts;
	return outcome;
}

} // namespace

int main(int argc, char** argv) { return stepProgram(argc, argv, run); }

#include "step/step.hpp"

#include "parallel/thread_team.hpp"

namespace rcr {

Pose poseAfter(const StepBody& body, const StepBody& owner, const PlanarVector& v, double time)
{
	const Turn turn   = v.rotation == 0 ? body.turn : turned(body.turn, time * v.rotation);
	Vec2       center = { body.center.x + time * v.x, body.center.y + time * v.y };
	if (&body != &owner) {
		const Vec2   arm = body.center - owner.center;
		const double c = std::cos(time * v.rotation), s = std::sin(time * v.rotation);
		center = { owner.center.x + time * v.x + c * arm.x - s * arm.y,
			owner.center.y + time * v.y + s * arm.x + c * arm.y };
	}
	return { center, turn.axis() };
}

/// u_n of an impact if the point closes faster than rounding errors, else 0 [m/s].
static double closingVelocity(const Step& step, const ContactPoint& c)
{
	constexpr double rounding = 1e-9; // of velocities, relative
	const StepBody & one = step.bodies[c.body1], &two = step.bodies[c.body2];
	const double fastest = maxSpeed(one.velocity, one.radius) + maxSpeed(two.velocity, two.radius);
	const double u       = step.impactVelocity(c).n;
	return u < -rounding * fastest ? u : 0;
}

double creepTolerance(const Step& step)
{
	constexpr double share = 3e-7;
	double           size  = 0;
	for (const StepContact& c : step.contacts)
		size += c.size;
	return step.contacts.empty() ? 0 : share * size / double(step.contacts.size()) / step.dt;
}

ContactPoint Step::contactPoint(const StepContact& contact, const ManifoldPoint& at) const
{
	ContactPoint c;
	c.body1    = bodies[contact.body1].owner;
	c.body2    = bodies[contact.body2].owner;
	c.normal   = at.normal;
	c.arm1     = at.position - bodies[c.body1].center;
	c.arm2     = at.position - (bodies[c.body2].center + contact.shift);
	c.friction = contact.law.friction;
	c.drift    = contact.drift;
	c.shift    = problem.stretches() ? contact.shift : Vec2 {};
	c.bias     = overdamped || at.gap > 0 ? at.gap / dt : 0;
	if (at.gap <= std::max(contact.slop(), contact.law.adhesionRange))
		c.pull = dt * contact.law.adhesion;
	if (contact.count == 1 && contact.law.rollingFriction > 0) {
		c.rollingFriction = contact.law.rollingFriction;
		c.rollingLength   = rollingLength(bodies[contact.body1].shape, bodies[contact.body2].shape);
	}
	if (overdamped || !(contact.law.restitution > 0)) return c;
	const double u = closingVelocity(*this, c);
	if (u < 0 && at.gap + dt * u < 0) c.bias = contact.law.restitution * u;
	return c;
}

void Step::resizePoints(int points)
{
	problem.points.resize(points);
	problem.impulse.resize(points);
	problem.rollingImpulse.assign(points, 0);
	rollingMoment.assign(points, 0);
	gap.resize(points);
	force.resize(points);
	widenedReach.assign(bodies.size(), 0);
	found.clear();
	widened.clear();
	added.clear();
	displacement.clear();
	problem.yielded.assign(bodies.size(), false);
	strain    = {};
	intruding = {};
}

void Step::setPoints(const StepContact& c, const Manifold& manifold, const LocalVector* from,
        double moment)
{
	for (int k = 0; k < c.count; ++k) {
		problem.points[c.first + k]  = contactPoint(c, manifold.points[k]);
		gap[c.first + k]             = { manifold.points[k].gap, -c.slop(), from[k].n != 0 };
		force[c.first + k]           = from[k];
		problem.impulse[c.first + k] = dt * from[k];
	}
	if (c.count != 1 || !problem.points[c.first].rolls()) return;
	rollingMoment[c.first]          = moment;
	problem.rollingImpulse[c.first] = rollingImpulse(problem.points[c.first], moment);
}

void Step::updateGradient(Vec2 before)
{
	if (!problem.stretches()) return;
	cell.gradient[0][0] += problem.stretchRate.x - before.x;
	cell.gradient[1][1] += problem.stretchRate.y - before.y;
	for (StepContact& c : contacts)
		c.drift = cell.drift(c.shift);
}

const StepContact* Step::find(int body1, int body2) const
{
	const FoundContact pair { body1, body2, {}, {} };
	const auto found = std::lower_bound(contacts.begin(), contacts.end(), pair, precedes);
	return found != contacts.end() && !precedes(pair, *found) ? &*found : nullptr;
}

double Step::roundingVelocity(ThreadTeam& team) const
{
	return 1e-12 * team.maximum(bodies.size(), [&](std::size_t id) {
		return maxSpeed(bodies[id].velocity, bodies[id].radius);
	});
}

void Step::computePointForces(ThreadTeam& team)
{
	const double inverseDt = 1 / dt;
	team.forEach(force.size(), [&](std::size_t k) {
		force[k]         = inverseDt * problem.impulse[k];
		const double p   = problem.rollingImpulse[k];
		rollingMoment[k] = p == 0 ? 0 : inverseDt * p * problem.points[k].rollingLength;
	});
}

} // namespace rcr

#include "step/step.hpp"

#include <algorithm>
#include <numeric>

#include "parallel/thread_team.hpp"
#include "step/restitution.hpp"

namespace rcr {

Pose moved(const StepBody& body, const StepBody& owner, const Twist& v, double time)
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

ContactPoint Step::contactPoint(const StepContact& c, const ManifoldPoint& at) const
{
	ContactPoint p;
	p.body1    = bodies[c.body1].owner;
	p.body2    = bodies[c.body2].owner;
	p.normal   = at.normal;
	p.arm1     = at.position - bodies[p.body1].center;
	p.arm2     = at.position - (bodies[p.body2].center + c.shift);
	p.friction = c.friction;
	p.drift    = c.drift;
	p.shift    = cell.stretches() ? c.shift : Vec2 {};
	p.bias     = overdamped
	            ? at.gap / dt
	            : lawBias(at.gap, c.restitution, dt, [&] { return initialVelocity(p).n; });
	return p;
}

void Step::begin(int points)
{
	problem.points.resize(points);
	problem.impulse.resize(points);
	gap.resize(points);
	force.resize(points);
	reach.assign(reach.size(), 0);
	updated.clear();
	widened.clear();
	added.clear();
	displacement.clear();
	strain = {};
}

void Step::setPoints(const StepContact& c, const Manifold& manifold, const Impulse* from)
{
	for (int k = 0; k < c.count; ++k) {
		problem.points[c.first + k]  = contactPoint(c, manifold.points[k]);
		gap[c.first + k]             = { manifold.points[k].gap, -c.slop(), from[k].n > 0 };
		force[c.first + k]           = from[k];
		problem.impulse[c.first + k] = dt * from[k];
	}
}

void Step::updateGradient(Vec2 before)
{
	if (!cell.stretches()) return;
	cell.gradient[0][0] += problem.stretch.x - before.x;
	cell.gradient[1][1] += problem.stretch.y - before.y;
	for (StepContact& c : contacts)
		c.drift = cell.drift(c.shift);
}

void Step::indexContacts()
{
	firstOf.assign(bodies.size() + 1, 0);
	for (const StepContact& c : contacts)
		++firstOf[c.body1 + 1];
	std::partial_sum(firstOf.begin(), firstOf.end(), firstOf.begin());
}

const StepContact* Step::find(int body1, int body2) const
{
	const auto begin = contacts.begin() + firstOf[body1],
	           end   = contacts.begin() + firstOf[body1 + 1];
	const auto found = std::lower_bound(
	        begin, end, body2, [](const StepContact& c, int body) { return c.body2 < body; });
	return found != end && found->body2 == body2 ? &*found : nullptr;
}

double Step::rounding(ThreadTeam& team) const
{
	return 1e-12 * team.maximum(bodies.size(), [&](std::size_t id) {
		return speed(bodies[id].velocity, bodies[id].radius);
	});
}

void Step::keepForces(ThreadTeam& team)
{
	const double inverseDt = 1 / dt;
	force.resize(problem.impulse.size());
	team.forEach(force.size(), [&](std::size_t k) { force[k] = inverseDt * problem.impulse[k]; });
}

} // namespace rcr

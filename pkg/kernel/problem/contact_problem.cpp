#include "problem/contact_problem.hpp"

#include "parallel/thread_team.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"

namespace rcr {

constexpr double normalTolerance = 2e-6; // deviation of |n|² from 1 [-]

static void checkSize(const char* what, std::size_t given, std::size_t expected)
{
	if (given != expected)
		refuse(what, " holds ", given, " entries; expected ", expected);
}

/// Error of a body; null: none.
static const char* bodyError(const InverseMass& m, const PlanarVector& v)
{
	if (!finite(m.x, m.y, m.rotation, v.x, v.y, v.rotation))
		return ": a mass or velocity is not finite";
	if (m.x < 0 || m.y < 0 || m.rotation < 0)
		return ": an inverse mass is negative; expected 1/m > 0, or 0 for prescribed motion";
	return nullptr;
}

/// Error of a contact point; null: none.
static const char* pointError(const ContactProblem& problem, std::size_t k)
{
	const ContactPoint& c      = problem.points[k];
	const LocalVector&  p      = problem.impulse[k];
	const std::size_t   bodies = problem.inverseMass.size();
	// a negative id becomes huge
	if (std::size_t(c.body1) >= bodies || std::size_t(c.body2) >= bodies)
		return ": body id out of range";
	if (c.body1 == c.body2) return ": both bodies are the same";
	if (!finite(c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias,
	            c.friction, c.drift.x, c.drift.y, c.shift.x, c.shift.y, c.pull, c.rollingFriction,
	            c.rollingLength, p.n, p.t, problem.rollingImpulseOf(k)))
		return ": a number is not finite";
	if (!(std::abs(dot(c.normal, c.normal) - 1) <= normalTolerance))
		return ": the normal is not of unit length";
	if (c.friction < 0) return ": the friction coefficient is negative; expected µ ≥ 0";
	if (c.friction > maxFriction)
		return ": the friction coefficient is above 1000, too large to measure errors; give a "
		       "friction angle of at most 89.9°";
	if (c.pull < 0) return ": the pull is negative; expected c ≥ 0 N s";
	if (c.rollingFriction < 0 || c.rollingFriction > maxFriction)
		return ": the coefficient of rolling friction is outside 0 … 1000";
	if (c.rolls() && !(c.rollingLength > 0))
		return ": a point with rolling friction needs a rolling length > 0";
	if (c.rolls() && problem.rollingImpulse.empty())
		return ": a point with rolling friction needs rollingImpulse";
	return nullptr;
}

void ContactProblem::setStretchRate(Vec2 now)
{
	for (ContactPoint& c : points)
		c = withStretchRate(c, now);
	stretchRate = now;
}

void ContactProblem::addStretch(Vec2 rate, std::vector<PlanarVector>& velocity) const
{
	for (std::size_t id = 0; id < place.size(); ++id) {
		velocity[id].x += rate.x * place[id].x;
		velocity[id].y += rate.y * place[id].y;
	}
}

Vec2 addImpulses(const ContactProblem& problem, const std::vector<LocalVector>& impulse,
        std::vector<PlanarVector>& velocity)
{
	Vec2 stretching; // M_c δg
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		applyImpulse(c, impulse[k], problem.inverseMass[c.body1], problem.inverseMass[c.body2],
		        velocity[c.body1], velocity[c.body2]);
		const Vec2 f = toCartesian(c.normal, impulse[k]);
		stretching   = stretching + componentwise(problem.stretchArm(c), f);
	}
	const Vec2 rate = componentwise(problem.inverseStretchMass, stretching);
	problem.addStretch(rate, velocity);
	return rate;
}

Vec2 velocitiesOf(const ContactProblem& problem, std::vector<PlanarVector>& velocity)
{
	velocity               = problem.freeVelocity;
	const Vec2 stretchRate = addImpulses(problem, problem.impulse, velocity);
	for (std::size_t k = 0; k < problem.rollingImpulse.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		applyRollingImpulse(c, problem.rollingImpulse[k], problem.inverseMass[c.body1],
		        problem.inverseMass[c.body2], velocity[c.body1], velocity[c.body2]);
	}
	return stretchRate;
}

void updateVelocity(ContactProblem& problem)
{
	const Vec2 stretchRate = velocitiesOf(problem, problem.velocity);
	if (problem.stretches()) problem.setStretchRate(stretchRate);
}

double drivenSpeed(const ContactProblem& problem)
{
	double     fastest = 0;
	const auto include = [&](int body, Vec2 arm) {
		const PlanarVector v = problem.prescribedMotion(body);
		fastest              = std::max(fastest, norm(Vec2 { v.x, v.y } + cross(v.rotation, arm)));
	};
	for (const ContactPoint& c : problem.points) {
		include(c.body1, c.arm1);
		include(c.body2, c.arm2);
		fastest = std::max(fastest, norm(c.drift));
	}
	return fastest;
}

bool isDriven(const ContactProblem& problem)
{
	constexpr double none = std::numeric_limits<double>::quiet_NaN();
	Vec2             common { none, none };
	const auto       differs = [](double& shared, double velocity) {
        if (std::isnan(shared)) shared = velocity;
        return velocity != shared;
	};
	const auto differsAt = [&](int body) {
		const InverseMass&  m = problem.inverseMass[body];
		const PlanarVector& v = problem.freeVelocity[body];
		return (m.x == 0 && differs(common.x, v.x)) || (m.y == 0 && differs(common.y, v.y))
		        || (m.rotation == 0 && v.rotation != 0);
	};
	// backwards: walls are often the last bodies
	return std::any_of(problem.points.rbegin(), problem.points.rend(), [&](const ContactPoint& c) {
		return c.drift.x != 0 || c.drift.y != 0 || differsAt(c.body1) || differsAt(c.body2);
	});
}

void checkProblem(const ContactProblem& problem, ThreadTeam& team)
{
	const std::size_t bodies = problem.inverseMass.size();
	checkSize("freeVelocity", problem.freeVelocity.size(), bodies);
	checkSize("impulse", problem.impulse.size(), problem.points.size());
	if (!problem.rollingImpulse.empty())
		checkSize("rollingImpulse", problem.rollingImpulse.size(), problem.points.size());
	if (!problem.yielded.empty()) checkSize("yielded", problem.yielded.size(), bodies);
	if (!problem.place.empty()) checkSize("place", problem.place.size(), bodies);
	if (!problem.recoveryBias.empty())
		checkSize("recoveryBias", problem.recoveryBias.size(), problem.points.size());
	const Vec2 m = problem.inverseStretchMass, g = problem.stretchRate;
	if (!finite(m.x, m.y, g.x, g.y) || m.x < 0 || m.y < 0)
		refuse("the cell: an inverse mass or stretch rate is not finite, or an inverse mass is "
		       "negative");
	for (std::size_t i = 0; i < bodies; ++i) {
		if (const char* error = bodyError(problem.inverseMass[i], problem.freeVelocity[i]))
			refuse("body ", i, error);
		const Vec2 place = problem.placeOf(int(i));
		if (!finite(place.x, place.y)) refuse("body ", i, ": its place is not finite");
	}
	team.forEach(problem.points.size(), [&](std::size_t k) {
		if (const char* error = pointError(problem, k))
			refuse("contact point ", k, error);
	});
}

} // namespace rcr

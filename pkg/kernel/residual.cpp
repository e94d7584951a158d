#include "residual.hpp"

#include "coulomb.hpp"

namespace rcr {

double residual(const ContactProblem& given)
{
	ContactProblem problem { given.inverseMass, given.freeVelocity, given.points, given.impulse, {} };
	updateVelocity(problem);
	double error2 = 0, impulse2 = 0, stopping2 = 0;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const Delassus      w = delassus(c, problem.inverseMass[c.body1], problem.inverseMass[c.body2]);
		if (w.nn <= 0) continue;
		const Impulse p = problem.impulse[k];
		const Impulse u = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
		const Impulse q = projectCone({ p.n - (u.n + c.bias + c.friction * std::abs(u.t)) / w.nn, p.t - u.t / w.nn }, c.friction);
		error2 += (p.n - q.n) * (p.n - q.n) + (p.t - q.t) * (p.t - q.t);
		impulse2 += p.n * p.n + p.t * p.t;
		const double stopping = (std::abs(u.n) + std::abs(c.bias)) / w.nn;
		stopping2 += stopping * stopping;
	}
	return relativeError(error2, impulse2, stopping2);
}

double violation(const ContactProblem& given)
{
	ContactProblem problem { given.inverseMass, given.freeVelocity, given.points, given.impulse, {} };
	updateVelocity(problem);
	double violation2 = 0, velocity2 = 0, freeVelocity2 = 0;
	for (const ContactPoint& c : problem.points) {
		if (delassus(c, problem.inverseMass[c.body1], problem.inverseMass[c.body2]).nn <= 0) continue;
		const Impulse u     = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
		const Impulse uFree = relativeVelocity(c, problem.freeVelocity[c.body1], problem.freeVelocity[c.body2]);
		const double  below = std::min(0.0, u.n + c.bias);
		violation2 += below * below;
		velocity2 += u.n * u.n + u.t * u.t;
		freeVelocity2 += uFree.n * uFree.n + uFree.t * uFree.t;
	}
	return violation2 == 0 ? 0 : std::sqrt(violation2 / std::max(velocity2, freeVelocity2));
}

} // namespace rcr

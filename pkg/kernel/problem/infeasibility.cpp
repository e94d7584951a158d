#include "problem/infeasibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "problem/coulomb.hpp"

namespace rcr {

namespace {

	constexpr double least = 1e-3; // of the largest impulse of a direction: smaller ones are its noise

	double mass(const InverseMass& m)
	{
		const double inverse = std::max(m.x, m.y);
		return inverse > 0 ? 1 / inverse : 0;
	}

	double work(const Impulse& p, const Impulse& u) { return p.n * u.n + p.t * u.t; }

	/// √(Σ m) max |u_free| where the direction acts.
	double typicalChange(const ContactProblem& problem, const std::vector<Impulse>& d)
	{
		double largest = 0, speed2 = 0, total = 0;
		for (const Impulse& one : d)
			largest = std::max(largest, one.n);
		std::vector<bool> acts(problem.inverseMass.size());
		for (std::size_t k = 0; k < d.size(); ++k) {
			if (d[k].n <= least * largest) continue;
			const ContactPoint& c = problem.points[k];
			const Impulse       u = relativeVelocity(c, problem.freeVelocity[c.body1], problem.freeVelocity[c.body2]);
			speed2                = std::max(speed2, work(u, u));
			acts[c.body1] = acts[c.body2] = true;
		}
		for (std::size_t i = 0; i < acts.size(); ++i)
			if (acts[i]) total += mass(problem.inverseMass[i]);
		return std::sqrt(total * speed2);
	}

} // namespace

double requiredSpeed(const ContactProblem& problem, const std::vector<Impulse>& direction)
{
	std::vector<Impulse> d(direction.size());
	std::vector<Twist>   moved(problem.inverseMass.size()); // M⁻¹Jᵀd
	for (std::size_t k = 0; k < d.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		d[k]                  = projectCone(direction[k], c.friction);
		applyImpulse(c, d[k], problem.inverseMass[c.body1], problem.inverseMass[c.body2], moved[c.body1], moved[c.body2]);
	}
	double pressed = 0, energy = 0; // −d · (u_free + b_n n) and dᵀJ M⁻¹Jᵀd
	for (std::size_t k = 0; k < d.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		pressed -= work(d[k], relativeVelocity(c, problem.freeVelocity[c.body1], problem.freeVelocity[c.body2])) + d[k].n * c.bias;
		energy += work(d[k], relativeVelocity(c, moved[c.body1], moved[c.body2]));
	}
	if (!(pressed > 0)) return 0;
	return energy > 0 ? pressed / std::sqrt(energy) / typicalChange(problem, d) : std::numeric_limits<double>::infinity();
}

} // namespace rcr

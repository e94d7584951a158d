#include "problem/infeasibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "problem/coulomb.hpp"

namespace rcr {

namespace {

	constexpr double beyond = 3;    // change of velocity that no solution is worth, over V
	constexpr double least  = 1e-3; // of the largest impulse of a direction: smaller ones are its noise

	double mass(const InverseMass& m)
	{
		const double inverse = std::max(m.x, m.y);
		return inverse > 0 ? 1 / inverse : 0;
	}

	double work(const Impulse& p, const Impulse& u) { return p.n * u.n + p.t * u.t; }

	/// V of a direction.
	double typicalChange(const ContactProblem& problem, const std::vector<Impulse>& d)
	{
		double largest = 0, speed2 = 0, opening = 0, total = 0;
		for (const Impulse& one : d)
			largest = std::max(largest, one.n);
		std::vector<bool> acts(problem.inverseMass.size());
		for (std::size_t k = 0; k < d.size(); ++k) {
			if (d[k].n <= least * largest) continue;
			const ContactPoint& c = problem.points[k];
			const Impulse       u = freeRelativeVelocity(problem, c);
			speed2                = std::max(speed2, work(u, u));
			opening += std::max(0.0, -c.bias);
			acts[c.body1] = acts[c.body2] = true;
		}
		for (std::size_t i = 0; i < acts.size(); ++i)
			if (acts[i]) total += mass(problem.inverseMass[i]);
		return std::sqrt(total) * (std::sqrt(speed2) + opening);
	}

	bool isTooMuch(double energy, double typicalChange) { return 2 * std::sqrt(std::max(energy, 0.0)) > beyond * typicalChange; }

} // namespace

double requiredSpeed(const ContactProblem& problem, const std::vector<Impulse>& direction)
{
	std::vector<Impulse> d(direction.size());
	std::vector<Twist>   moved(problem.inverseMass.size()); // M⁻¹Jᵀd
	Vec2                 stretching;
	for (std::size_t k = 0; k < d.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		d[k]                  = projectCone(direction[k], c.friction);
		applyImpulse(c, d[k], problem.inverseMass[c.body1], problem.inverseMass[c.body2], moved[c.body1], moved[c.body2]);
		stretching = stretching + componentwise(c.shift, d[k].n * c.normal + d[k].t * perp(c.normal));
	}
	const Vec2 stretch = componentwise(problem.inverseStretchMass, stretching);
	double pressed = 0, energy = 0; // −d · (u_free + b_n n) and dᵀJ M⁻¹Jᵀd
	for (std::size_t k = 0; k < d.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		pressed -= work(d[k], freeRelativeVelocity(problem, c)) + d[k].n * c.bias;
		ContactPoint still = c; // impulses move the image of a body by the cell's stretch alone
		still.drift        = componentwise(stretch, c.shift);
		energy += work(d[k], relativeVelocity(still, moved[c.body1], moved[c.body2]));
	}
	if (!(pressed > 0)) return 0;
	return energy > 0 ? pressed / (std::sqrt(energy) * typicalChange(problem, d)) : std::numeric_limits<double>::infinity();
}

double energyTaken(const ContactProblem& problem)
{
	double energy = 0;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const Impulse&      p = problem.impulse[k];
		energy -= work(p, relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2])) + p.n * c.bias;
	}
	return energy;
}

bool worseThanNone(const ContactProblem& problem)
{
	double sum = 0;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const Impulse&      p = problem.impulse[k];
		const Impulse       u = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
		sum += 0.5 * (work(p, u) + work(p, freeRelativeVelocity(problem, c))) + p.n * c.bias;
	}
	return !(sum <= 0); // nor is it where impulses are so large that their products overflow
}

bool takesTooMuch(const ContactProblem& problem) { return isTooMuch(energyTaken(problem), typicalChange(problem, problem.impulse)); }

bool mayTakeTooMuch(const ContactProblem& problem, double energy, double freeSpeed)
{
	double total = 0;
	for (const InverseMass& m : problem.inverseMass)
		total += mass(m);
	return isTooMuch(energy, std::sqrt(total) * freeSpeed);
}

bool growsWithoutBound(const ContactProblem& problem, const std::vector<Impulse>& before)
{
	double               grown2 = 0, size2 = 0;
	std::vector<Impulse> d(before.size());
	for (std::size_t k = 0; k < d.size(); ++k) {
		const Impulse& p = problem.impulse[k];
		d[k]             = { p.n - before[k].n, p.t - before[k].t };
		grown2 += work(d[k], d[k]);
		size2 += work(p, p);
	}
	return grown2 > leastGrowth * leastGrowth * size2 && requiredSpeed(problem, d) > beyond;
}

} // namespace rcr

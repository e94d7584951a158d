// Gauss–Seidel sweeps with Nesterov momentum on the impulses, restarted when a step grows.
//
//   y    = p + β (p − p_old),  β = (τ − 1)/τ⁺,  τ⁺ = (1 + √(1 + 4 τ²))/2
//   p_old ← p,  p ← sweep(y);  τ ← 1 when ‖p − p_old‖² has grown by more than 10 %
//
// The velocities are linear in the impulses and extrapolated with them.
// Source: Nesterov 1983; O'Donoghue and Candès 2015 (restart); Mazhar et al. 2015 (momentum in contact dynamics).
#include <algorithm>

#include "coulomb.hpp"
#include "residual.hpp"
#include "solver.hpp"

namespace rcr {

namespace {

	constexpr double maxGrowth = 1.1; // of ‖Δp‖² before momentum starts anew; 1 restarts too often after noise

	void sweep(ContactProblem& problem, const std::vector<Delassus>& w)
	{
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			if (w[k].nn <= 0) continue;
			const ContactPoint& c  = problem.points[k];
			Twist&              v1 = problem.velocity[c.body1];
			Twist&              v2 = problem.velocity[c.body2];
			Impulse&            p  = problem.impulse[k];
			const Impulse       u  = relativeVelocity(c, v1, v2);
			const Impulse       next
			        = solveCoulomb(w[k], u.n + c.bias - w[k].nn * p.n - w[k].nt * p.t, u.t - w[k].nt * p.n - w[k].tt * p.t, c.friction);
			applyImpulse(c, { next.n - p.n, next.t - p.t }, problem.inverseMass[c.body1], problem.inverseMass[c.body2], v1, v2);
			p = next;
		}
	}

	/// now ← now + β (now − before), before ← now
	void extrapolate(double& now, double& before, double beta)
	{
		const double value = now;
		now += beta * (value - before);
		before = value;
	}

	double distance2(const std::vector<Impulse>& p, const std::vector<Impulse>& q)
	{
		double sum = 0;
		for (std::size_t k = 0; k < p.size(); ++k)
			sum += (p[k].n - q[k].n) * (p[k].n - q[k].n) + (p[k].t - q[k].t) * (p[k].t - q[k].t);
		return sum;
	}

} // namespace

Report solveNesterov(ContactProblem& problem, const Settings& settings)
{
	std::vector<Delassus> w;
	for (const ContactPoint& c : problem.points)
		w.push_back(delassus(c, problem.inverseMass[c.body1], problem.inverseMass[c.body2]));
	updateVelocity(problem);
	std::vector<Impulse> oldImpulse  = problem.impulse;
	std::vector<Twist>   oldVelocity = problem.velocity;
	double               tau = 1, step = 0;
	Report               report { 0, residual(problem) };
	while (!report.reached(settings) && report.iterations < settings.maxIterations) {
		const double next = (1 + std::sqrt(1 + 4 * tau * tau)) / 2, beta = (tau - 1) / next;
		for (std::size_t k = 0; k < problem.impulse.size(); ++k) {
			extrapolate(problem.impulse[k].n, oldImpulse[k].n, beta);
			extrapolate(problem.impulse[k].t, oldImpulse[k].t, beta);
		}
		for (std::size_t i = 0; i < problem.velocity.size(); ++i) {
			extrapolate(problem.velocity[i].x, oldVelocity[i].x, beta);
			extrapolate(problem.velocity[i].y, oldVelocity[i].y, beta);
			extrapolate(problem.velocity[i].rotation, oldVelocity[i].rotation, beta);
		}
		sweep(problem, w);
		const double grown = distance2(problem.impulse, oldImpulse);
		tau                = grown > maxGrowth * step && step > 0 ? 1 : next;
		step               = grown;
		if (++report.iterations % settings.checkInterval == 0 || report.iterations == settings.maxIterations)
			report.residual = residual(problem);
	}
	updateVelocity(problem);
	report.converged = report.residual <= settings.tolerance;
	return report;
}

} // namespace rcr

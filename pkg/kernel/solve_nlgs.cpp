// Nonlinear Gauss–Seidel over single contact points, in the order of the problem: the paper's solver, also over-relaxed.
// Source: Jean 1999; Moreau 1999.
#include "coulomb.hpp"
#include "residual.hpp"
#include "solver.hpp"

namespace rcr {

namespace {

	/// One pass over all points; `velocity` follows every change of `impulse`.
	void sweep(ContactProblem& problem, const std::vector<Delassus>& w, double relaxation)
	{
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			if (w[k].nn <= 0) continue;
			const ContactPoint& c  = problem.points[k];
			Twist&              v1 = problem.velocity[c.body1];
			Twist&              v2 = problem.velocity[c.body2];
			Impulse&            p  = problem.impulse[k];
			const Impulse       u  = relativeVelocity(c, v1, v2);
			const double        gn = u.n + c.bias - w[k].nn * p.n - w[k].nt * p.t;
			const double        gt = u.t - w[k].nt * p.n - w[k].tt * p.t;
			const Impulse       solved = solveCoulomb(w[k], gn, gt, c.friction);
			const Impulse       next   = relaxation == 1
                                ? solved
                                : projectCone({ p.n + relaxation * (solved.n - p.n), p.t + relaxation * (solved.t - p.t) }, c.friction);
			const Impulse       change { next.n - p.n, next.t - p.t };
			p = next;
			applyImpulse(c, change, problem.inverseMass[c.body1], problem.inverseMass[c.body2], v1, v2);
		}
	}

	Report gaussSeidel(ContactProblem& problem, const Settings& settings, double relaxation)
	{
		std::vector<Delassus> w;
		for (const ContactPoint& c : problem.points)
			w.push_back(delassus(c, problem.inverseMass[c.body1], problem.inverseMass[c.body2]));
		updateVelocity(problem);
		Report report { 0, residual(problem) };
		while (!report.reached(settings) && report.iterations < settings.maxIterations) {
			sweep(problem, w, relaxation);
			if (++report.iterations % settings.checkInterval == 0 || report.iterations == settings.maxIterations)
				report.residual = residual(problem);
		}
		updateVelocity(problem);
		report.converged = report.residual <= settings.tolerance;
		return report;
	}

} // namespace

Report solveNlgs(ContactProblem& problem, const Settings& settings) { return gaussSeidel(problem, settings, 1.0); }
Report solveSor(ContactProblem& problem, const Settings& settings) { return gaussSeidel(problem, settings, 1.3); }

} // namespace rcr

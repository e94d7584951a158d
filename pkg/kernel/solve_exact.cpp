// Proximal point iteration with exact steps: residuals of 1e-8 and below, where sweeps stall.
//
//   p ← accelerated sweeps to about 1e-4
//   repeat  p_ref ← p;  p ← solution of the contact law softened by w_nn/ρ about p_ref;  ρ ← 10 ρ
//
// A step is one linear solve where the pieces guessed from p_ref hold, else a path from p_ref to the solution, pivot by
// pivot (path_following.hpp). Where a path is lost, sweeps move the reference and ρ is lowered. The residual does not
// fall monotonously, so the best iterate is kept.
// Source: Rockafellar 1976; Acary, Brémond and Huber 2018, §5 (proximal point for frictional contact).
#include <algorithm>

#include "path_following.hpp"
#include "proximal_problem.hpp"
#include "residual.hpp"
#include "solver.hpp"

namespace rcr {

namespace {

	constexpr double handover     = 1e-4; // residual at which sweeps hand over
	constexpr int    maxSweeps    = 3000; // … or their number
	constexpr double rhoStart     = 1e3, rhoLeast = 1, rhoMost = 1e6, rhoFactor = 10; // beyond 1e6 rounding is seen
	constexpr int    maxPivots    = 2000; // of one path
	constexpr int    rescueSweeps = 300;  // after a lost path

	/// The best impulses seen so far.
	struct Best {
		double               residual;
		std::vector<Impulse> impulse;

		void offer(double candidate, const ContactProblem& problem)
		{
			if (!(candidate < residual)) return;
			residual = candidate;
			impulse  = problem.impulse;
		}
	};

	struct Outcome {
		bool solved;
		int  iterations; // linear solves
	};

	/// Solves the proximal problem about its reference.
	Outcome proximalStep(ProximalProblem& proximal, int maxIterations)
	{
		proximal.guessPieces();
		if (!proximal.factor()) return { false, 1 };
		proximal.solveLinear();
		if (proximal.updatePieces() == 0) return { true, 1 };
		const PathEnd end = followPath(proximal, std::min(maxPivots, maxIterations));
		return { end.arrived, 2 + end.pivots };
	}

	Report sweep(ContactProblem& problem, double tolerance, int iterations, const Settings& settings)
	{
		Settings sweeps      = settings;
		sweeps.tolerance     = tolerance;
		sweeps.maxIterations = iterations;
		return solve(problem, "nesterov", sweeps);
	}

} // namespace

Report solveExact(ContactProblem& problem, const Settings& settings)
{
	Report report = sweep(problem, std::max(settings.tolerance, handover), std::min(settings.maxIterations, maxSweeps), settings);
	if (report.reached(settings)) return report;
	ProximalProblem proximal(problem);
	double          residualNow = proximal.setReference(problem), rho = rhoStart;
	Best            best { residualNow, problem.impulse };
	while (!(settings.tolerance > 0 && best.residual <= settings.tolerance) && report.iterations < settings.maxIterations) {
		proximal.setStiffness(rho);
		const Outcome step = proximalStep(proximal, settings.maxIterations - report.iterations);
		report.iterations += step.iterations;
		if (step.solved) {
			proximal.store(problem);
			rho = std::min(rhoMost, rhoFactor * rho);
		} else {
			const int left = settings.maxIterations - report.iterations;
			if (left > 0) report.iterations += sweep(problem, 0, std::min(rescueSweeps, left), settings).iterations;
			rho = std::max(rhoLeast, rho / rhoFactor);
		}
		best.offer(proximal.setReference(problem), problem);
	}
	problem.impulse = best.impulse;
	updateVelocity(problem);
	report.residual  = residual(problem);
	report.converged = report.residual <= settings.tolerance;
	return report;
}

} // namespace rcr

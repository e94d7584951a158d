// Proximal point iteration with exact steps: residuals of 1e-8 and below, where sweeps stall.
//
//   p ← accelerated sweeps to about 1e-4
//   repeat  p_ref ← p;  p ← solution of the contact law softened by w_nn/ρ about p_ref
//
// A step follows the path from p_ref to its solution, pivot by pivot (path_following.hpp). The stiffer, the fewer steps,
// until the path folds back: sliding is not associated, so the solution near p_ref can cease to exist, and the next one
// is a finite way off. Then a softer step still has its one solution, and softer steps run away from the unstable
// state until they come upon the next. The residual rises on the way, so the best iterate is kept.
// Source: Rockafellar 1976; Acary, Brémond and Huber 2018, §5 (proximal point for frictional contact).
#include <algorithm>

#include "path_following.hpp"
#include "proximal_problem.hpp"
#include "residual.hpp"
#include "solver.hpp"

namespace rcr {

namespace {

	constexpr double handover  = 1e-4; // residual at which sweeps hand over
	constexpr int    maxSweeps = 3000; // … or their number
	constexpr int    maxPivots = 2000; // of one path

	/// ρ over the steps: stiffer while paths arrive, softer where one folds.
	class Stiffness {
	public:
		double rho() const { return rho_; }

		void arrived()
		{
			if (raised_) patience_ = std::max(1, patience_ / 2);
			raised_ = ++steps_ >= patience_;
			if (!raised_) return;
			steps_ = 0;
			rho_   = std::min(most, factor * rho_);
		}

		/// Running away takes time: after every fold twice as many steps before the next raise.
		void folded()
		{
			patience_ = std::min(maxPatience, 2 * patience_);
			steps_    = 0;
			raised_   = false;
			rho_      = std::max(least, rho_ / factor);
		}

	private:
		static constexpr double least = 1e-2, start = 1e3, most = 1e6; // beyond 1e6 rounding is seen
		static constexpr double factor = 10;
		static constexpr int    maxPatience = 64;

		double rho_      = start;
		int    patience_ = 1; // steps at one ρ before it is raised
		int    steps_    = 0;
		bool   raised_   = false; // by the last step
	};

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

	Report sweep(ContactProblem& problem, const Settings& settings)
	{
		Settings sweeps      = settings;
		sweeps.tolerance     = std::max(settings.tolerance, handover);
		sweeps.maxIterations = std::min(settings.maxIterations, maxSweeps);
		return solve(problem, "nesterov", sweeps);
	}

} // namespace

Report solveExact(ContactProblem& problem, const Settings& settings)
{
	Report report = sweep(problem, settings);
	if ((report.converged && report.reached(settings)) || report.iterations >= settings.maxIterations) return report;
	ProximalProblem proximal(problem);
	Stiffness       stiffness;
	Best            best { report.residual, problem.impulse };
	while (!(best.residual <= settings.tolerance) && report.iterations < settings.maxIterations) {
		proximal.setReference(problem);
		proximal.setStiffness(stiffness.rho());
		const PathEnd end = followPath(proximal, std::min(maxPivots, settings.maxIterations - report.iterations));
		report.iterations += 1 + end.pivots;
		end.arrived ? stiffness.arrived() : stiffness.folded();
		proximal.store(problem);
		best.offer(residual(problem), problem);
	}
	problem.impulse = best.impulse;
	updateVelocity(problem);
	report.residual  = residual(problem);
	report.violation = violation(problem);
	report.converged = report.residual <= settings.tolerance && report.violation <= settings.violation;
	return report;
}

} // namespace rcr

// Proximal point iteration with exact steps: residuals of 1e-8 and below, where sweeps stall.
//
//   p ← accelerated sweeps to about 1e-5
//   repeat  p_ref ← p;  p ← solution of the contact law softened by w_nn/ρ about p_ref
//
// A step follows the path from p_ref to its solution, pivot by pivot (path_following.hpp). The stiffer, the fewer steps,
// until the path folds back: sliding is not associated, so the solution near p_ref can cease to exist, and the next one
// is a finite way off. Then softer steps, at the contacts concerned, still have their one solution and run away from the
// unstable state, as sweeps do, until they come upon the next. The residual rises on the way: the best iterate is kept.
// Source: Rockafellar 1976; Acary, Brémond and Huber 2018, §5 (proximal point for frictional contact).
#include <algorithm>
#include <cmath>
#include <limits>

#include "exact/path_following.hpp"
#include "exact/proximal_problem.hpp"
#include "exact/proximal_parameter.hpp"
#include "problem/infeasibility.hpp"
#include "problem/residual.hpp"
#include "problem/solver.hpp"

namespace rcr {

namespace {

	constexpr double handover     = 1e-5; // residual at which sweeps hand over; later gains little, earlier costs folds
	constexpr int    maxSweeps    = 1000; // … or their number, at most half of all iterations
	constexpr int    rescueSweeps = 300;  // after a fold; 100 to 1000 do as well …
	constexpr int    pivotSweeps  = 20;   // … and for each pivot of the path as many as it cost, about
	constexpr int    maxPivots    = 2000; // of one path

	/// Of each contact: stiffer while paths arrive, softer where one folds. Beyond 1e6 rounding is seen.
	constexpr Stiffness::Limits stiffnessLimits { 1e3, 1e-2, 1e6, 10, 10, 64 };

	/// The best impulses seen so far.
	struct Best {
		double               residual, kinematicError;
		std::vector<Impulse> impulse;

		/// How far from both criteria; ≤ 1 where both are met. Of a criterion of 0 the lower value is still the better one.
		double distance(const Settings& s) const
		{
			constexpr double least = std::numeric_limits<double>::min();
			return std::max(residual / std::max(s.tolerance, least), kinematicError / std::max(s.kinematicTolerance, least));
		}

		void offer(const Best& other, const Settings& settings)
		{
			if (other.distance(settings) < distance(settings)) *this = other;
		}
	};

	/// Accelerated sweeps, `most` of them or fewer if the residual `tolerance` is reached before.
	Report sweep(ContactProblem& problem, const Settings& settings, double tolerance, int most, Workspace& workspace)
	{
		Settings sweeps      = settings;
		sweeps.tolerance     = tolerance;
		sweeps.kinematicTolerance     = std::numeric_limits<double>::infinity(); // left to the exact steps
		sweeps.maxIterations = most;
		return solveNesterov(problem, sweeps, workspace);
	}

	/// Sweeps to the handover. A start with impulses so large that their squares overflow is given up for one without any.
	Report begin(ContactProblem& problem, const Settings& settings, Workspace& workspace)
	{
		const double tolerance = std::max(settings.tolerance, handover);
		const auto   most      = [](int left) { return std::min(maxSweeps, (left + 1) / 2); };
		const Report report    = sweep(problem, settings, tolerance, most(settings.maxIterations), workspace);
		const int    left      = settings.maxIterations - report.iterations;
		if (!std::isnan(report.residual) || left == 0) return report;
		problem.impulse.assign(problem.points.size(), {});
		Settings cold  = settings;
		cold.sameProblem = false;
		Report again   = sweep(problem, cold, tolerance, most(left), workspace);
		again.iterations += report.iterations;
		again.work += report.work;
		return again;
	}

	/// One step about the present impulses; returns how its path ended.
	PathEnd step(ContactProblem& problem, ProximalProblem& proximal, std::vector<Stiffness>& stiffness, int maxIterations)
	{
		proximal.setReference(problem);
		for (std::size_t i = 0; i < proximal.size(); ++i)
			proximal.stiffness[i] = stiffness[i].rho() / proximal.contacts[i].wnn;
		const PathEnd end = followPath(proximal, std::min(maxPivots, std::max(maxIterations, 2) - 1));
		proximal.store(problem);
		for (std::size_t i : end.unstable)
			stiffness[i].failed();
		if (end.unstable.empty())
			for (Stiffness& one : stiffness)
				end.arrived ? one.arrived() : one.failed();
		return end;
	}

} // namespace

Report solveExact(ContactProblem& problem, const Settings& settings, Workspace& workspace, const Report* swept)
{
	std::vector<Impulse> before; // the last sweeps or steps, where these may show that there is no solution
	const auto           remember      = [&] {
                if (settings.yieldCompliance > 0) before = problem.impulse;
	};
	const auto hasNoSolution = [&] { return settings.yieldCompliance > 0 && (exceedsEnergyBound(problem) || isDivergent(problem, before)); };
	remember();
	Report report;
	if (swept) {
		report            = *swept;
		report.kinematicError  = kinematicError(problem, settings.velocityFloor);
		report.iterations = 0, report.work = 0;
	} else {
		report           = begin(problem, settings, workspace);
		report.converged = report.reached(settings) && report.kinematicError <= settings.kinematicTolerance;
		if (report.converged || report.iterations >= settings.maxIterations) return report;
		report.yielded = hasNoSolution();
		if (report.yielded) return report;
	}
	ProximalProblem        proximal(problem);
	std::vector<Stiffness> stiffness(proximal.size(), Stiffness(stiffnessLimits));
	Best                   best { report.residual, report.kinematicError, problem.impulse };
	const auto             left = [&] { return settings.maxIterations - report.iterations; };
	while (!(best.distance(settings) <= 1) && left() > 0) {
		remember();
		const PathEnd end = step(problem, proximal, stiffness, left() / settings.exactCost);
		report.iterations += settings.exactCost * (1 + end.pivots);
		report.yielded = hasNoSolution();
		if (report.yielded) return report;
		best.offer({ residual(problem), kinematicError(problem, settings.velocityFloor), problem.impulse }, settings);
		if (!end.arrived && left() > 0) {
			const int most = std::min(rescueSweeps + pivotSweeps * end.pivots, left());
			Settings  again     = settings;
			again.sameProblem     = true;
			remember();
			report.iterations += sweep(problem, again, 0, most, workspace).iterations;
			report.yielded = hasNoSolution();
			if (report.yielded) return report;
		}
	}
	problem.impulse = best.impulse;
	updateVelocity(problem);
	report.residual  = residual(problem);
	report.kinematicError = kinematicError(problem, settings.velocityFloor);
	report.dissipated     = dissipatedEnergy(problem);
	report.impulseGrowth     = std::numeric_limits<double>::infinity(); // what sweeps before told is over
	report.converged = report.residual <= settings.tolerance && report.kinematicError <= settings.kinematicTolerance;
	return report;
}

} // namespace rcr

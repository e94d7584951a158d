// Proximal point iteration with exact steps: residuals of 1e-8 and below, where sweeps stall.
//
//   p ← accelerated sweeps to about 1e-5
//   repeat  p_ref ← p;  p ← solution of the contact law softened by w_nn/ρ about p_ref
//
// A step follows the path from p_ref to its solution (path_following.hpp). Large ρ needs few steps
// until a path folds: sliding is not associated, so the solution near p_ref can cease to exist.
// Then smaller ρ at the contacts concerned, and sweeps, leave the unstable state. Meanwhile the
// residual rises; the best iterate is kept.
// Source: Rockafellar 1976; Acary, Brémond and Huber 2018, §5 (proximal point for friction).

#include "exact/path_following.hpp"
#include "exact/proximal_parameter.hpp"
#include "problem/infeasibility.hpp"
#include "problem/residual.hpp"
#include "problem/solver.hpp"

namespace rcr {

namespace {

	/// Residual at which exact steps begin. A smaller one gains little; a larger one causes folds.
	constexpr double sweptResidual = 1e-5;

	constexpr int maxSweeps    = 1000; // before the exact steps; at most half of maxIterations
	constexpr int repairSweeps = 300;  // after a fold; 100 to 1000 do as well
	constexpr int pivotSweeps  = 20; // more sweeps per pivot of the path; they cost about a pivot
	constexpr int maxPivots    = 2000; // of one path; ten a point in slim islands if that is more

	constexpr double leastFall = 0.7; // of ‖d‖ in a step that does not diverge [-]

	/// The best impulses so far: those that meet the limits, or with the smallest residual.
	struct Best : Errors {
		Impulses impulses;

		void offer(const Best& other, const Settings& settings)
		{
			if (other.meets(settings) || !(other.residual >= residual)) *this = other; // also of NaN
		}
	};

	/// At most `maxIterations` accelerated sweeps, until the residual `tolerance` is reached.
	Report sweep(ContactProblem& problem, const Settings& settings, double tolerance,
	        int maxIterations, Workspace& workspace)
	{
		Settings sweeps           = settings;
		sweeps.tolerance          = tolerance;
		sweeps.accuracy           = unknownError; // exact steps meet it
		sweeps.maxIterations      = maxIterations;
		return solveNesterov(problem, sweeps, workspace);
	}

	double softestParameter(const std::vector<ProximalParameter>& rho)
	{
		double softest = std::numeric_limits<double>::infinity();
		for (const ProximalParameter& one : rho)
			softest = std::min(softest, one.rho());
		return softest;
	}

	/// A complete proximal step; zeros: none.
	struct Moved {
		double distance = 0, rho = 0; // from its reference [-], softest parameter
	};

	/// Error after a step, from its distance. A step lowers the smoothest error by 1 + ρ/κ. κ is at
	/// least the condition of the island, that of rows and columns. Without friction, the distance
	/// of the last step shows how large it is; with friction, states that change hide it.
	double errorOfStep(double distance, double rho, const Moved& last, double condition,
	        const IslandShape& shape)
	{
		const double assumed = distance * (condition / rho);
		if (shape.frictional || distance == 0) return assumed;
		if (last.distance == 0) return shape.slim() ? assumed : unknownError;
		const double growth = distance / last.distance, most = rho / last.rho;
		if (growth >= most) return unknownError;
		return std::max(assumed, distance * growth / (most - growth));
	}

	/// One proximal step about the present impulses.
	PathEnd proximalStep(ContactProblem& problem, ProximalProblem& proximal,
	        std::vector<ProximalParameter>& rho, int most)
	{
		proximal.setReference(problem);
		for (std::size_t i = 0; i < proximal.size(); ++i)
			proximal.stiffness[i] = rho[i].rho() / proximal.contacts[i].wnn;
		const PathEnd end = followPath(proximal, most);
		proximal.store(problem);
		for (std::size_t i : end.unstable)
			rho[i].stepFailed();
		if (end.unstable.empty())
			for (ProximalParameter& one : rho)
				end.complete ? one.stepConverged() : one.stepFailed();
		return end;
	}

} // namespace

Report sweepForExactSteps(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	const double tolerance = std::max(settings.tolerance, sweptResidual);
	const int    most      = std::min(maxSweeps, (settings.maxIterations + 1) / 2);
	Report       report    = sweep(problem, settings, tolerance, most, workspace);
	report.converged       = true;
	for (Report& island : report.islands) {
		island.converged = island.meets(settings.forGoalOf(island.shape));
		report.converged = report.converged && island.converged;
	}
	return report;
}

Report solveExact(ContactProblem& problem, const Settings& settings, const Report& swept,
        Workspace& workspace, int cost)
{
	if (settings.maxIterations <= 0) return swept; // factorisations cost more than many sweeps
	// impulses before the last sweeps or step, to detect divergence
	std::vector<LocalVector> before;
	const auto               remember = [&] {
        if (settings.mayYield()) before = problem.impulse;
	};
	Report     report   = swept;
	Measures   now      = measuresOf(problem); // of the last impulses
	const auto mustYield = [&] {
		const double last = now.error2;
		now               = measuresOf(problem);
		if (!settings.mayYield()) return false;
		// impulses that grow and lower the error in the laws approach a solution
		const bool falls = now.error2 < leastFall * leastFall * last;
		report.yielded = exceedsEnergyBound(problem) || (!falls && isDivergent(problem, before));
		return report.yielded;
	};
	report.iterations = 0, report.work = 0;
	ProximalProblem                proximal(problem);
	const double                   condition = conditionOf(problem, swept.shape);
	std::vector<ProximalParameter> rho(proximal.size(), ProximalParameter(10 * condition));
	const auto iterate = [&](double estimate) -> Best {
		return { { residualFromSums(now), creepOf(now, problem.points.size()), estimate },
			problem.impulses() };
	};
	Best         best      = iterate(report.errorEstimate);
	Moved        last;
	const auto left = [&] { return settings.maxIterations - report.iterations; };
	const int  longestPath = swept.shape.slim() ? std::max(maxPivots, 10 * swept.shape.points)
	                                            : maxPivots;
	while (!best.meets(settings) && left() > 0) {
		remember();
		const Impulses reference = problem.impulses();
		const double  softest = softestParameter(rho);
		const PathEnd end     = proximalStep(problem, proximal, rho,
                        std::min(longestPath, std::max(left() / cost, 2) - 1));
		report.iterations += cost * (1 + end.pivots);
		if (mustYield()) return report.plusCostOf(swept);
		updateVelocity(problem);
		const double distance = distanceFrom(problem, reference, swept.shape);
		Best next = iterate(end.complete
		                ? errorOfStep(distance, softest, last, condition, swept.shape)
		                : unknownError);
		last = end.complete ? Moved { distance, softest } : Moved {};
		// a smaller residual than that of the sweeps, and so hardly a larger error
		if (next.residual <= swept.residual)
			next.errorEstimate = std::min(next.errorEstimate, swept.errorEstimate);
		best.offer(next, settings);
		if (!end.complete && left() > 0) {
			const int most    = std::min(repairSweeps + pivotSweeps * end.pivots, left());
			remember();
			report.iterations += sweep(problem, settings, 0, most, workspace).iterations;
			if (settings.mayYield() && mustYield()) return report.plusCostOf(swept);
		}
	}
	problem.setImpulses(best.impulses);
	updateVelocity(problem);
	static_cast<Errors&>(report) = best;
	report.dissipated            = dissipatedEnergy(problem);
	report.impulseGrowth         = std::numeric_limits<double>::infinity(); // unknown after exact steps
	report.converged     = report.meets(settings);
	return report.plusCostOf(swept);
}

} // namespace rcr

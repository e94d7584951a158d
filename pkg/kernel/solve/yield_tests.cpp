#include "solve/yield_tests.hpp"

#include <numeric>

#include "problem/infeasibility.hpp"
#include "problem/residual.hpp"

namespace rcr {

// a pass with fewer iterations is too short for a hint of divergence
constexpr int    minIterationsToProbe = 100;
// bound for growing impulses over V_s from which they are probed; 0.04 in sheared packings
constexpr double suspiciousBound = 0.1;
// a rigid contact may exceed yieldImpulse by this many impulses |b_n|/w_nn of its rebound
constexpr double mostRebounds = 3;

bool hasYielded(const ContactProblem& problem)
{
	return std::find(problem.yielded.begin(), problem.yielded.end(), true) != problem.yielded.end();
}

bool mustYieldAt(const ContactProblem& problem, std::size_t k, const Settings& settings)
{
	const ContactPoint& c      = problem.points[k];
	const double        excess = problem.impulse[k].n - settings.yielding.yieldImpulse;
	return (excess > 0 && excess * delassus(problem, c).nn > mostRebounds * std::max(0.0, -c.bias))
	        || closesBlocked(problem, c, settings.roundingVelocity);
}

/// Returns true if a blocked contact closes by more than rounding errors of the largest |u_free|.
static bool anyClosesBlocked(const ContactProblem& problem, const Settings& settings)
{
	double largest2 = 0;
	for (const ContactPoint& c : problem.points)
		largest2 = std::max(largest2, square(freeRelativeVelocity(problem, c)));
	const double rounding = std::max(settings.roundingVelocity, roundingShare * std::sqrt(largest2));
	return std::any_of(problem.points.begin(), problem.points.end(),
	        [&](const ContactPoint& c) { return closesBlocked(problem, c, rounding); });
}

bool isFalseSolution(const ContactProblem& problem, const Settings& settings)
{
	return exceedsChangeBound(problem) || anyClosesBlocked(problem, settings);
}

bool hasPositiveCost(const ContactProblem& problem, PointIterator first, PointIterator last)
{
	const double cost = std::accumulate(first, last, 0.0, [&](double sum, std::int32_t k) {
		const ContactPoint& c = problem.points[k];
		const LocalVector & p = problem.impulse[k], u = relativeVelocity(problem, c);
		return sum + (0.5 * (dot(p, u) + dot(p, freeRelativeVelocity(problem, c))) + p.n * c.bias);
	});
	return !(cost <= 0); // true also if products of large impulses overflow to NaN
}

/// Runs probeSweeps sweeps on a copy of the problem. Returns true if the impulses diverge.
static bool probeDivergence(
        const ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	Settings sweeps      = settings;
	sweeps.tolerance     = 0;
	sweeps.minIterations = sweeps.maxIterations = probeSweeps;
	ContactProblem probe                        = problem;
	solveNesterov(probe, sweeps, workspace);
	return isDivergent(probe, problem.impulse);
}

bool mayDiverge(const Report& report, const Settings& settings)
{
	return !(report.impulseGrowth <= divergentGrowth)
	        && settings.maxIterations >= minIterationsToProbe;
}

bool mayExceedEnergyBound(const Report& report)
{
	return exceedsEnergyBound(report.dissipated, std::sqrt(report.mass) * report.freeSpeed);
}

bool mustYield(const Report& report, const ContactProblem& problem, const Settings& settings,
        Workspace& workspace, const std::vector<LocalVector>& before, bool probes)
{
	if (!settings.mayYield()) return false;
	if (report.yielded || (mayExceedEnergyBound(report) && exceedsEnergyBound(problem)))
		return true;
	for (std::size_t k = 0; k < problem.points.size(); ++k)
		if (mustYieldAt(problem, k, settings)) return true;
	if (report.converged || settings.tolerance == 0) return false;
	if (hasYielded(problem)) return true;
	if (!probes || !mayDiverge(report, settings)) return false;
	if (!before.empty() && !(boundOfGrowth(problem, before) > suspiciousBound)) return false;
	return probeDivergence(problem, settings, workspace);
}

} // namespace rcr

#include "solve/solve_auto.hpp"

#include <cmath>

namespace rcr {

constexpr int    firstSweeps  = 300; // of a small problem, before it may give up
constexpr int    stallIterations = 30, trendIterations = 50; // exact ones that sweeps may cost
constexpr int    fineProblem  = 250;  // points; solved beyond the goal of a packing with friction
constexpr int    sweepsPerExact = 20; // cost of an exact iteration of a small problem [sweeps]
constexpr int    maxFineWork = 15000; // most exact iterations × points beyond the goal of an island
constexpr int    slimSweeps  = 50; // of slim islands before exact steps, or half the diameter
constexpr double slimAim = 0.1; // of the accuracy: errors of successive steps add up
constexpr int    moreIterations = 3; // per point and maxIterations, for slim islands at rest

/// Cost of exact iterations [sweeps]. Measured for one: 20 at 1000 points, 220 at 25 000.
static int sweepsFor(int exactIterations, int points)
{
	const double size = std::pow(std::max(1.0, double(points) / smallProblem), 0.75);
	return int(exactIterations * sweepsPerExact * size);
}

Settings firstSweepsOfAuto(const Settings& settings, const IslandShape& shape)
{
	if (settings.tolerance == 0) return settings.forGoalOf(shape);
	Settings sweeps    = settings;
	sweeps.stallSweeps = sweepsFor(stallIterations, shape.points);
	if (shape.slim()) {
		sweeps.accuracy *= slimAim;
		sweeps.maxIterations = std::min(
		        std::max(slimSweeps, shape.diameter / 2), settings.maxIterations);
		return sweeps;
	}
	if (shape.points > fineProblem) sweeps.accuracy = shape.goal(settings.accuracy);
	if (shape.points <= smallProblem) {
		const int  most    = sweepsFor(trendIterations, shape.points);
		const bool relaxed = sweeps.accuracy > settings.accuracy; // sweeps may reach it
		sweeps.trend       = { firstSweeps, most, relaxed ? most : 0 };
	}
	return sweeps;
}

Report continueAuto(ContactProblem& problem, const Settings& settings, const Report& swept,
        Workspace& workspace)
{
	const int      points = int(problem.points.size());
	const bool     slim = swept.shape.slim(), small = points <= smallProblem;
	const Settings goal = settings.forGoalOf(swept.shape);
	Report         report   = swept;
	const auto     left     = [&] { return settings.maxIterations - report.iterations; };
	const auto     runExact = [&](const Settings& limits, int iterations, int cost) {
        Settings steps      = limits;
        steps.maxIterations = iterations;
        report              = solveExact(problem, steps, report, workspace, cost);
	};
	if (slim) {
		Settings aim = settings;
		aim.accuracy *= slimAim;
		const bool goesOn = settings.solutionExists && settings.maxIterations > slimSweeps;
		const int  more   = goesOn ? moreIterations * settings.maxIterations : 0;
		runExact(aim, left() + std::min(more, moreIterations * points), 1);
	} else if (!small) {
		runExact(goal, left(), 1);
	} else {
		const bool residualMet    = report.meetsResidual(settings);
		int        fineIterations = left();
		if (residualMet) { // limits the work of exact steps beyond the goal
			fineIterations = std::min(left(), maxFineWork / points);
			if (left() > fineIterations && !report.meets(goal)) {
				Settings sweeps      = goal;
				sweeps.stallSweeps   = sweepsFor(stallIterations, points);
				sweeps.maxIterations = left() - fineIterations;
				report               = solveNesterov(problem, sweeps, workspace).plusCostOf(report);
			}
		}
		const Settings& fine = points <= fineProblem ? settings : goal;
		runExact(fine, fineIterations, residualMet ? 1 : sweepsPerExact);
		if (!report.yielded && !report.meets(goal))
			runExact(goal, left(), sweepsPerExact);
	}
	Settings verdict = goal;
	// exact iterations of a slim island with friction may end where solutions branch
	verdict.accuracy = swept.shape.spreadGoal(settings.accuracy);
	report.converged = report.meets(verdict);
	return report;
}

} // namespace rcr

#include "solve/solve.hpp"

#include <cmath>

#include "problem/island_problem.hpp"
#include "problem/residual.hpp"
#include "solve/pull_substitution.hpp"
#include "solve/solve_auto.hpp"
#include "solve/stages.hpp"
#include "solve/yield_tests.hpp"
#include "sweep/packed_problem.hpp"

namespace rcr {

/// Returns true if a test of divergence needs the impulses before the last sweeps, and they are
/// known.
static bool needsEarlierImpulses(const Report& swept, const Settings& settings)
{
	return settings.mayYield() && std::isfinite(swept.impulseGrowth)
	        && mayDiverge(swept, settings);
}

/// Completes the islands that have not converged, or that may have no solution.
static Report completeIslands(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Report report, Workspace& workspace)
{
	std::vector<std::int32_t> begin, points;
	workspace.packed().listPoints(begin, points);
	const auto perhapsMustYield = [&](std::int32_t k) {
		const ContactPoint& c = problem.points[k];
		return problem.hasYielded(c.body1) || problem.hasYielded(c.body2)
		        || mustYieldAt(problem, k, settings);
	};
	const auto needsMore = [&](const Report& island, PointIterator first, PointIterator last) {
		if (!settings.solutionExists
		        && (settings.yielding.compliance == 0
		                || mayExceedEnergyBound(island)
		                || std::any_of(first, last, perhapsMustYield)))
			return true;
		if (island.converged) return false;
		const bool isSmall = last - first <= smallProblem || island.shape.slim(); // few sweeps
		return (takesExactSteps(solver, settings)
		               && (isSmall || island.iterations < settings.maxIterations))
		        || (settings.mayYield() && mayDiverge(island, settings))
		        || hasPositiveCost(problem, first, last);
	};
	std::vector<Report>       islands = std::move(report.islands);
	std::vector<std::int32_t> numbers(problem.inverseMass.size(), unnumbered);
	std::vector<LocalVector>  earlier; // impulsesBeforeProbe of all islands
	bool                      changed = false;
	for (std::size_t number = 0; number < islands.size(); ++number) {
		Report&             island = islands[number];
		const PointIterator first  = points.begin() + begin[number],
		                    last   = points.begin() + begin[number + 1];
		if (!needsMore(island, first, last)) continue;
		IslandProblem part(problem, { first, last }, numbers);
		Workspace     own;
		std::vector<LocalVector> before;
		if (needsEarlierImpulses(island, settings)) {
			if (earlier.empty()) earlier = impulsesBeforeProbe(workspace);
			for (PointIterator k = first; k != last; ++k)
				before.push_back(earlier[*k]);
		}
		island = complete(part.problem, solver, settings, island, own, std::move(before));
		part.store(problem);
		changed = true;
	}
	if (changed) {
		// islands without errors report 0, not rounding errors
		const bool solved = std::all_of(islands.begin(), islands.end(),
		        [](const Report& island) { return island.residual == 0; });
		report.residual = solved ? 0 : residualOf(problem);
		report.impulseGrowth = std::numeric_limits<double>::infinity(); // not measured
	}
	report.combine(std::move(islands));
	return report;
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings,
        Workspace& workspace)
{
	checkProblem(problem, workspace.team());
	checkSettings(solver, settings);
	const PullSubstitution pulled(problem);
	Report swept = sweepTogether(problem, solver, settings, workspace);
	if (swept.islands.size() <= 1)
		return complete(problem, solver, settings, swept, workspace,
		        needsEarlierImpulses(swept, settings) ? impulsesBeforeProbe(workspace)
		                                              : std::vector<LocalVector> {});
	return completeIslands(problem, solver, settings, std::move(swept), workspace);
}

} // namespace rcr

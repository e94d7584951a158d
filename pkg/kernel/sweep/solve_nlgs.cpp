// Nonlinear Gauss–Seidel over the contact points, plain (the solver of the paper) or over-relaxed.
// Source: Jean 1999; Moreau 1999.
#include "sweep/sweep_solver.hpp"

namespace rcr {

template <class Sweep>
static Report solvePlainly(
        ContactProblem& problem, const Settings& settings, Workspace& workspace, Sweep sweep)
{
	return solveBySweeps(problem, settings, workspace, [&](PackedIsland& island, IslandStop& stop) {
		island.beginMixedPrecision();
		while (!stop.mustStop())
			sweep(island);
		island.endMixedPrecision();
	});
}

Report solveNlgs(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solvePlainly(
	        problem, settings, workspace, [](PackedIsland& island) { island.sweep(); });
}

Report solveSor(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solvePlainly(problem, settings, workspace,
	        [](PackedIsland& island) { island.sweepRelaxed(relaxation); });
}

} // namespace rcr

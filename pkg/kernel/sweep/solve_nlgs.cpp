// Nonlinear Gauss–Seidel over the contact points, plain (the solver of the paper) or over-relaxed.
// Source: Jean 1999; Moreau 1999.
#include "sweep/sweep_solver.hpp"

namespace rcr {

Report solveNlgs(
        ContactProblem& problem, const Settings& settings, Workspace& workspace, double relaxation)
{
	return solveBySweeps(problem, settings, workspace, [&](PackedIsland& island, IslandStop& stop) {
		island.beginMixedPrecision();
		while (!stop.mustStop())
			island.sweep(relaxation);
		island.endMixedPrecision();
	});
}

} // namespace rcr

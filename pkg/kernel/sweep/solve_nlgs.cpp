// Nonlinear Gauss–Seidel over single contact points: the paper's solver, also over-relaxed.
// Source: Jean 1999; Moreau 1999.
#include "sweep/sweep_solver.hpp"

namespace rcr {

namespace {
	constexpr double relaxation = 1.3; // a third fewer sweeps in dense packings; from 1.6 on it cycles
}

Report solveNlgs(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solveBySweeps(problem, settings, workspace, [](PackedIsland& island, IslandStop& stop) {
		while (!stop.reached())
			island.sweep();
	});
}

Report solveSor(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solveBySweeps(problem, settings, workspace, [](PackedIsland& island, IslandStop& stop) {
		while (!stop.reached())
			island.sweepRelaxed(relaxation);
	});
}

} // namespace rcr

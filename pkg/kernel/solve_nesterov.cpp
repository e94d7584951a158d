// Gauss–Seidel sweeps with Nesterov momentum on the impulses (momentum.hpp), restarted when it leads away.
//
// The velocities are linear in the impulses and extrapolated with them.
#include "momentum.hpp"
#include "sweep_solver.hpp"

namespace rcr {

Report solveNesterov(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solveBySweeps(problem, settings, workspace, [](PackedIsland& island, StopTest& stop) {
		Momentum momentum;
		while (!stop.reached()) {
			island.extrapolate(momentum.beta());
			momentum.advance(island.sweepMomentum(momentum.beta()));
		}
	});
}

} // namespace rcr

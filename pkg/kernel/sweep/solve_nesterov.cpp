// Gauss–Seidel sweeps with Nesterov momentum on the impulses (momentum.hpp), restarted when it leads away.
//
// The velocities are linear in the impulses and extrapolated with them. Large islands are swept in floats about a reference in doubles,
// down to the tolerance or to `finestSingle`, whichever comes first; doubles confirm that, or go on.
#include "problem/infeasibility.hpp"
#include "sweep/momentum.hpp"
#include "sweep/sweep_solver.hpp"

namespace rcr {

namespace {

	void sweep(PackedIsland& island, Momentum& momentum) { momentum.advance(island.sweepMomentum(momentum.beta())); }

} // namespace

Report solveNesterov(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solveBySweeps(problem, settings, workspace, [&](PackedIsland& island, IslandStop& stop) {
		Momentum momentum;
		island.beginSingle();
		while (!stop.reached()) {
			if (stop.sweeps() == settings.maxIterations - probeSweeps + 1) island.remember(); // the first sweep is 1
			sweep(island, momentum);
		}
		island.endSingle();
	});
}

void sweepWithBias(const ContactProblem& problem, const std::vector<double>& bias, int sweeps, std::vector<Twist>& velocity, Vec2& stretch, Workspace& workspace)
{
	PackedProblem& packed = workspace.packed();
	packed.rebias(problem, bias);
	packed.forEachIsland([&](PackedIsland&& island) {
		Momentum momentum;
		island.beginSingle();
		for (int k = 0; k < sweeps; ++k)
			sweep(island, momentum);
		island.endSingle();
	});
	packed.storeVelocity(problem, velocity);
	stretch = packed.stretch();
}

} // namespace rcr

// Gauss–Seidel sweeps with Nesterov momentum on the impulses (momentum.hpp), with restart.
//
// Velocities are linear in the impulses and are extrapolated with them. Large islands are swept in
// mixed precision (packed_island.hpp). The stop criteria are confirmed in doubles.
#include "sweep/momentum.hpp"
#include "sweep/sweep_solver.hpp"

namespace rcr {

static void sweep(PackedIsland& island, Momentum& momentum)
{
	momentum.advance(island.sweepMomentum(momentum.beta()));
}

Report solveNesterov(ContactProblem& problem, const Settings& settings, Workspace& workspace,
        IslandSettings ofIsland)
{
	const auto iterate = [&](PackedIsland& island, IslandStop& stop) {
		Momentum momentum;
		island.beginMixedPrecision();
		while (!stop.mustStop())
			sweep(island, momentum);
		island.endMixedPrecision();
	};
	return solveBySweeps(problem, settings, workspace, iterate, ofIsland);
}

void sweepWithBias(const ContactProblem& problem, const std::vector<double>& bias, int sweeps,
        std::vector<PlanarVector>& velocity, Vec2& stretchRate, Workspace& workspace)
{
	PackedProblem& packed = workspace.packed();
	packed.reload(problem, bias);
	packed.forEachIsland([&](PackedIsland&& island) {
		Momentum momentum;
		island.beginMixedPrecision();
		for (int k = 0; k < sweeps; ++k)
			sweep(island, momentum);
		island.endMixedPrecision();
	});
	packed.storeVelocity(problem, velocity);
	stretchRate = packed.stretchRate();
}

} // namespace rcr

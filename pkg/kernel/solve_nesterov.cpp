// Gauss–Seidel sweeps with Nesterov momentum on the impulses, restarted when a step grows.
//
//   y = p + β (p − p_old),  β = (τ − 1)/τ⁺,  τ⁺ = (1 + √(1 + 4 τ²))/2
//   p_old ← p,  p ← sweep(y)
//   τ ← 1 where ‖p − p_old‖² has grown by more than 10 %, else τ⁺
//
// The velocities are linear in the impulses and extrapolated with them.
// Source: Nesterov 1983; O'Donoghue and Candès 2015 (restart); Mazhar et al. 2015 (momentum in contact dynamics).
#include <cmath>

#include "sweep_solver.hpp"

namespace rcr {

namespace {
	constexpr double maxGrowth = 1.1; // of ‖p − p_old‖² before momentum starts anew
}

Report solveNesterov(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	return solveBySweeps(problem, settings, workspace, [](PackedProblem& packed, StopTest& stop) {
		double tau = 1, step2 = std::numeric_limits<double>::infinity();
		while (!stop.reached()) {
			const double next = (1 + std::sqrt(1 + 4 * tau * tau)) / 2, momentum = (tau - 1) / next;
			packed.extrapolate(momentum);
			const Step   step = packed.sweepMomentum(momentum);
			tau               = step.size2 > maxGrowth * step2 ? 1 : next;
			step2 = step.size2;
		}
	});
}

} // namespace rcr

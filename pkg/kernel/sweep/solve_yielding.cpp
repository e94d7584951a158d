// A step without a solution: contacts yield.
//
// The contact laws hold for u' = u + ε' W p in place of u:
//
//   ε' = ε max(1, w₀/w_nn),   W = Delassus block of the point (components w_nn, w_nt, w_tt)
//
// Existence: let A = J M⁻¹Jᵀ ≥ 0, q = u_free + b_n n, and u' = (A + ε' W) p + q. Then p · u' =
// −µ p_n |u'_t| ≤ 0 bounds the impulses: ε' pᵀWp ≤ −pᵀq. So a solution exists for any motion of
// driven bodies.
// Energy: p · u = p · u' − ε' pᵀWp ≤ 0, so contacts add no energy.
// A body that can only turn has a singular block, W = j jᵀ/I: its points yield without friction.
// Forces: a point closes at ε max(w_nn, w₀) p_n. Without w₀, a body that can only turn would bear
// any force at a contact whose lever is tiny. A wedged body shares the imposed motion among its
// contacts, as dashpots with the coefficient 1/(ε' w_nn dt) would. The solution of one point is
// 1/(1 + ε') of the rigid one, because the laws are homogeneous. Sweeps with momentum converge in
// about 1/√ε sweeps. Overlaps are corrected no faster than the driven motion. So the force of a
// contact grows with its overlap, as with springs. Source: Acary, Cadoux, Lemaréchal and Malick
// 2011 (existence); Castro et al. 2022 (near-rigid regime of a convex relative).
#include "problem/residual.hpp"
#include "sweep/momentum.hpp"
#include "sweep/sweep_solver.hpp"

namespace rcr {

/// Returns true if the bodies of the point can only turn about one axis, or not move at all.
static bool isSingular(const Delassus& w)
{
	return w.nn * w.tt - w.nt * w.nt <= 1e-9 * w.nn * w.tt;
}

/// Sweeps until the relative change of the impulses is below `tolerance`, or the settings stop.
static void sweepToRest(
        PackedIsland& island, IslandStop& stop, const Yielding& yielding, double tolerance)
{
	constexpr int interval = 10;
	Momentum      momentum;
	while (!stop.mustStop()) {
		const double change2 = island.sweepMomentum(momentum.beta(), yielding);
		momentum.advance(change2);
		if (stop.sweeps() % interval == 0
		        && change2 <= tolerance * tolerance * island.measure().impulse2)
			break;
	}
}

Report solveYielding(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	constexpr int maxSweeps = 1000;
	Settings      sweeps    = settings;
	sweeps.tolerance        = 0;
	sweeps.meanForceChange  = 0;
	sweeps.minIterations    = 0;
	sweeps.stallSweeps      = 0;
	sweeps.checkInterval    = maxSweeps;
	sweeps.maxIterations    = maxSweeps;
	const double tolerance  = settings.tolerance > 0 ? settings.tolerance : Settings().tolerance;
	const double fastest = drivenSpeed(problem), yieldImpulse = settings.yielding.yieldImpulse;
	const std::vector<ContactPoint> given = problem.points;
	bool                            isChanged = false;
	// without friction, the law of a point bounds its impulse even if its block is singular
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		ContactPoint& c = problem.points[k];
		if (c.friction == 0 || !isSingular(delassus(problem, c))) continue;
		c.friction           = 0;
		problem.impulse[k].t = 0;
		isChanged            = true;
	}
	// rounding errors of larger impulses would hide those of other contacts
	for (LocalVector& p : problem.impulse)
		if (p.n > yieldImpulse) p = yieldImpulse / p.n * p;
	for (std::size_t k = 0; k < problem.recoveryBias.size(); ++k) {
		if (!(problem.recoveryBias[k] < 0)) continue; // no overlap
		// correct overlaps no faster than the driven motion
		const double recovery  = std::max(problem.recoveryBias[k], -fastest);
		problem.points[k].bias = std::min(problem.points[k].bias, recovery);
	}
	Workspace  frictionless; // the position correction goes on with the problem of the workspace
	Workspace& used   = isChanged ? frictionless : workspace;
	Report     report = solveBySweeps(
	        problem, sweeps, used, [&](PackedIsland& island, IslandStop& stop) {
		        sweepToRest(island, stop, settings.yielding, tolerance);
	        });
	for (std::size_t k = 0; k < given.size(); ++k) {
		problem.points[k].bias     = given[k].bias;
		problem.points[k].friction = given[k].friction;
	}
	report.residual      = residualOf(problem);
	report.errorEstimate = unknownError;
	report.yielded               = true;
	report.converged             = false;
	return report;
}

} // namespace rcr

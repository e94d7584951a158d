// A step without a solution, in the sense of the least violation: contacts yield.
//
//   the contact laws between p and u + ε W p,   W = the point's own Delassus block,  ε = Settings::compliance
//
// Then a solution exists for any driven motion: u' = (A + ε W) p + q with A = J M⁻¹Jᵀ ≥ 0, and p · u' = −µ p_n |u'_t| ≤ 0 bounds it,
// ε pᵀWp ≤ −pᵀq. No energy is given: p · u = p · u' − ε pᵀWp ≤ 0. A point closes by ε w_nn p_n: what wedges shares out what the drive imposes,
// as dashpots of the mass 1/w_nn and the time ε dt would. At a point, the solution is 1/(1 + ε) of the rigid one, since the laws are
// homogeneous; sweeps with momentum reach it in some 1/√ε. Overlaps are taken back meanwhile, no faster than the drive, so that grains give way to
// each other as springs do: the force of a contact grows with its overlap.
// Source: Acary, Cadoux, Lemaréchal and Malick 2011 (existence); Castro et al. 2022 (near-rigid regime of a convex relative).
#include "problem/infeasibility.hpp"
#include "sweep/momentum.hpp"
#include "sweep/sweep_solver.hpp"

namespace rcr {

namespace {

	constexpr double negligible  = 0.01; // of all energy that contacts take: an island that takes less and is solved stays rigid

	/// Sweeps until one changes the impulses by less than the share `tolerance`, or the settings end it.
	void sweepToRest(PackedIsland& island, IslandStop& stop, double compliance, double tolerance)
	{
		constexpr int interval = 10;
		Momentum      momentum;
		while (!stop.reached()) {
			const double change2 = island.sweepYielding(momentum.beta(), compliance);
			momentum.advance(change2);
			if (stop.sweeps() % interval == 0 && change2 <= tolerance * tolerance * island.measure().impulse2) break;
		}
	}

} // namespace

bool isDivergent(const ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	Settings sweeps      = settings;
	sweeps.sameProblem     = true;
	sweeps.tolerance     = 0;
	sweeps.minIterations = sweeps.maxIterations = probeSweeps;
	ContactProblem probe = problem;
	solveNesterov(probe, sweeps, workspace);
	return isDivergent(probe, problem.impulse);
}

Report solveYielding(ContactProblem& problem, const Settings& settings, const Report& rigid, Workspace& workspace)
{
	constexpr int most  = 1000; // sweeps
	Settings      sweeps   = settings;
	sweeps.sameProblem       = true;
	sweeps.tolerance       = 0;
	sweeps.meanForceChange = 0;
	sweeps.minIterations   = 0;
	sweeps.stallSweeps     = 0;
	sweeps.checkInterval   = most;
	sweeps.maxIterations   = most;
	const double tolerance = settings.tolerance > 0 ? settings.tolerance : Settings().tolerance;
	const double        fastest = fastestPrescribedMotion(problem);
	std::vector<double> rigidBias;
	for (std::size_t k = 0; k < problem.recovery.size(); ++k) {
		rigidBias.push_back(problem.points[k].bias);
		problem.points[k].bias = std::min(problem.points[k].bias, std::max(problem.recovery[k], -fastest)); // no faster than what drives
	}
	Report report = solveBySweeps(problem, sweeps, workspace, [&](PackedIsland& island, IslandStop& stop) {
                const Measures measures = island.measure();
                const bool     stays    = stop.meets(settings) && measures.taken <= negligible * rigid.dissipated && measures.impulse2 <= settings.yieldImpulse * settings.yieldImpulse;
                if (!stays) sweepToRest(island, stop, settings.yieldCompliance, tolerance);
        });
	report.yielded         = true;
	report.converged       = false;
	for (std::size_t k = 0; k < rigidBias.size(); ++k)
		problem.points[k].bias = rigidBias[k];
	for (const ContactPoint& c : problem.points)
		report.closingSpeed = std::max(report.closingSpeed, -c.bias - relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]).n);
	return report;
}

} // namespace rcr

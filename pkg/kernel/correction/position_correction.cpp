#include "correction/position_correction.hpp"

#include "parallel/thread_team.hpp"

namespace rcr {

// over the radius of a body; of a wall, see wallLength; also the largest strain of a cell
constexpr double largestShift = 1e-4;
constexpr int    sweeps       = 10;

/// Half the smallest R₁ + R₂ of the contacts [m]. It replaces the radius of walls, which is 0.
static double wallLength(const Step& step)
{
	double smallest = std::numeric_limits<double>::infinity();
	for (const StepContact& c : step.contacts)
		smallest = std::min(smallest, c.size);
	return 0.5 * smallest;
}

/// Bias ≤ 0 with which a point removes the fraction β of its overlap beyond the slop [m/s].
static double recoveryBias(const Step& step, std::size_t k, double beta)
{
	return std::min(0.0, beta * (step.gap[k].atStart - step.gap[k].threshold) / step.dt);
}

void setRecoveryBias(Step& step, double beta, ThreadTeam& team)
{
	step.problem.recoveryBias.resize(step.gap.size());
	team.forEach(step.gap.size(),
	        [&](std::size_t k) { step.problem.recoveryBias[k] = recoveryBias(step, k, beta); });
}

void computeCorrection(Step& step, double beta, Workspace& workspace)
{
	if (beta == 0 || step.overdamped) return;
	if (std::none_of(step.gap.begin(), step.gap.end(),
	            [](const Gap& gap) { return gap.atStart < gap.threshold; }))
		return;
	const ContactProblem& problem = step.problem;
	ThreadTeam&           team    = workspace.team();
	std::vector<double>   bias(step.gap.size());
	team.forEach(bias.size(), [&](std::size_t k) {
		const double law = problem.points[k].bias, recovery = recoveryBias(step, k, beta);
		bias[k]          = recovery < 0 ? std::min(law, recovery) : law;
	});
	sweepWithBias(problem, bias, sweeps, step.displacement, step.strain, workspace);
	step.strain       = step.dt * (step.strain - problem.stretchRate);
	const double wall = wallLength(step);
	const auto   byStrain = [&](std::size_t id) {
        const Vec2 d = componentwise(step.strain, problem.placeOf(int(id)));
        return PlanarVector { d.x, d.y, 0 };
	};
	// displacement over the radius, without that by the strain
	const double farthest = team.maximum(step.bodies.size(), [&](std::size_t id) {
		const StepBody& body = step.bodies[id];
		PlanarVector&   d    = step.displacement[id];
		d = body.free ? step.dt * (d - problem.velocity[id]) - byStrain(id) : PlanarVector {};
		return maxSpeed(d, body.radius) / (body.radius > 0 ? body.radius : wall);
	});
	const double share = std::min(1.0,
	        largestShift / std::max({ farthest, std::abs(step.strain.x), std::abs(step.strain.y) }));
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		step.displacement[id] = share * (step.displacement[id] + byStrain(id));
	});
	step.strain = share * step.strain;
}

} // namespace rcr

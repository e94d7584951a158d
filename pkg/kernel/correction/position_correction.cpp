#include "correction/position_correction.hpp"

#include <algorithm>

#include "parallel/thread_team.hpp"

namespace rcr {

namespace {
	constexpr double largestShift = 1e-4; // over the radius of a grain
	constexpr int    sweeps       = 10;
}

void prepareRecovery(Step& step, double beta, ThreadTeam& team)
{
	step.problem.recovery.resize(step.gap.size());
	team.forEach(step.gap.size(), [&](std::size_t k) {
		step.problem.recovery[k]
		        = std::min(0.0, beta * (step.gap[k].now - step.gap[k].allowed) / step.dt);
	});
}

void correctPositions(Step& step, double beta, Workspace& workspace)
{
	step.displacement.clear();
	step.strain = {};
	if (beta == 0 || step.overdamped) return;
	if (std::none_of(step.gap.begin(), step.gap.end(),
	            [](const Gap& gap) { return gap.now < gap.allowed; }))
		return;
	const ContactProblem& problem = step.problem;
	std::vector<double>   bias(step.gap.size());
	workspace.team().forEach(bias.size(), [&](int k) {
		const double excess = step.gap[k].now - step.gap[k].allowed, law = problem.points[k].bias;
		bias[k]             = excess < 0 ? std::min(law, beta * excess / step.dt) : law;
	});
	sweepWithBias(problem, bias, sweeps, step.displacement, step.strain, workspace);
	ThreadTeam&        team     = workspace.team();
	// displacement over the radius
	const double farthest = team.maximum(step.bodies.size(), [&](std::size_t id) {
		const StepBody& body = step.bodies[id];
		const Twist &   v = problem.velocity[id], &with = step.displacement[id];
		step.displacement[id] = body.free ? Twist { step.dt * (with.x - v.x),
			step.dt * (with.y - v.y), step.dt * (with.rotation - v.rotation) }
		                                  : Twist {};
		return body.free && body.radius > 0
		        ? speed(step.displacement[id], body.radius) / body.radius
		        : 0;
	});
	const double share = std::min(1.0, largestShift / farthest);
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		step.displacement[id] = share * step.displacement[id];
	});
	step.strain = (share * step.dt) * (step.strain - problem.stretch);
}

} // namespace rcr

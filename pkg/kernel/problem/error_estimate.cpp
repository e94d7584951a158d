#include "problem/error_estimate.hpp"

#include "problem/residual.hpp"

namespace rcr {

constexpr double slowestRate = 0.9; // of s, unknown above
constexpr double frictionalFit = 0.5, frictionalPower = 0.4; // fits to measured true errors
constexpr double leastChange2 = 1e-4; // of ‖v − v_free‖_M² over ‖p‖_w²

/// ‖v − v_free‖_M², at least that of bodies at rest.
static double velocityScale2(double velocity, double impulse)
{
	return std::max(velocity, leastChange2 * impulse);
}

double errorFromChange(
        const IterateChange& c, double residualRatio, int sweeps, const IslandShape& shape)
{
	if (c.impulse == 0) return c.error == 0 ? 0 : unknownError;
	const double change = std::sqrt(c.impulseChange / c.impulse);
	if (shape.frictional && !shape.slim())
		return frictionalFit * std::pow(change * shape.points / sweeps, frictionalPower);
	const double rate = std::sqrt(residualRatio);
	if (!(rate <= slowestRate)) return unknownError;
	const double forces = change * rate / (1 - rate);
	const double velocities = std::sqrt(std::sqrt(c.error * c.impulse) * forces
	        / velocityScale2(c.velocity, c.impulse));
	return shape.slim() ? std::max(forces, velocities) : velocities;
}

NormWeights::NormWeights(
        const IslandShape& shape, double meanResponse, const LargestMass& largest)
{
	constexpr double heavy = 30; // mass of a contact or body over the mean
	if (shape.slim()) {
		factor = std::max(1.0, largest.any * meanResponse);
		return;
	}
	leastResponse = meanResponse / heavy;
	if (!shape.frictional)
		factor = std::max(1.0, std::sqrt(largest.noWall * meanResponse / heavy));
}

static NormWeights weightsOf(const ContactProblem& problem, const IslandShape& shape)
{
	double response = 0;
	for (const ContactPoint& c : problem.points)
		response += delassus(problem, c).nn;
	LargestMass mass;
	for (const InverseMass& m : problem.inverseMass)
		mass.include(m);
	return { shape, response / double(std::max<std::size_t>(problem.points.size(), 1)), mass };
}

double conditionOf(const ContactProblem& problem, const IslandShape& shape)
{
	return weightsOf(problem, shape).factor * shape.condition();
}

double distanceFrom(
        const ContactProblem& problem, const Impulses& before, const IslandShape& shape)
{
	const NormWeights           weights = weightsOf(problem, shape);
	const double                least   = weights.leastResponse;
	std::vector<LocalVector>    change(before.contact.size());
	std::vector<PlanarVector>   dv(problem.inverseMass.size());
	double                      change2 = 0, impulse2 = 0, velocity2 = 0, own2 = 0;
	for (std::size_t k = 0; k < change.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		change[k]             = problem.impulse[k] - before.contact[k];
		const double w        = delassus(problem, c).nn;
		if (w < least) continue;
		change2 += w * square(change[k]);
		impulse2 += w * square(problem.impulse[k]);
		if (!c.rolls()) continue;
		const double rolling = problem.rollingImpulse[k] - before.rolling[k],
		             wr      = rollingResponse(problem, c);
		change2 += wr * rolling * rolling;
		impulse2 += wr * problem.rollingImpulse[k] * problem.rollingImpulse[k];
		applyRollingImpulse(c, rolling, problem.inverseMass[c.body1], problem.inverseMass[c.body2],
		        dv[c.body1], dv[c.body2]);
	}
	if (impulse2 == 0) return change2 == 0 ? 0 : unknownError;
	addImpulses(problem, change, dv);
	for (std::size_t i = 0; i < dv.size(); ++i) {
		const InverseMass& m = problem.inverseMass[i];
		if (m.translates() && 1 / m.mass() < least) continue;
		const auto energy = [&](const PlanarVector& v) {
			return (m.x > 0 ? v.x * v.x / m.x : 0) + (m.y > 0 ? v.y * v.y / m.y : 0)
			        + (m.rotation > 0 ? v.rotation * v.rotation / m.rotation : 0);
		};
		velocity2 += energy(dv[i]);
		own2 += energy(problem.velocity[i] - problem.freeVelocity[i]);
	}
	return std::sqrt(std::max(change2 / impulse2, velocity2 / velocityScale2(own2, impulse2)));
}

} // namespace rcr

#include "problem/residual.hpp"

namespace rcr {

Measures measuresOf(const ContactProblem& problem)
{
	std::vector<PlanarVector> velocity;
	const Vec2                stretchRate = velocitiesOf(problem, velocity);
	Measures m;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c  = problem.points[k];
		const PlanarVector &v1 = velocity[c.body1], &v2 = velocity[c.body2];
		const double        w  = delassus(problem, c).nn;
		if (w > 0) {
			const LocalVector u = problem.stretches()
			        ? relativeVelocity(problem.withStretchRate(c, stretchRate), v1, v2)
			        : relativeVelocity(c, v1, v2);
			m += measuresOf(problem.impulse[k], u, c.bias, c.friction, w);
		}
		if (c.rolls())
			m += rollingMeasures(problem.rollingImpulse[k], rollingVelocity(c, v1, v2),
			        c.rollingFriction * problem.impulse[k].n, rollingResponse(problem, c));
	}
	return m;
}

double creepOf(const Measures& m, double points)
{
	if (!(points > 0)) return 0;
	constexpr double share = 0.2; // in sheared packings, 0.1 costs three times the sweeps
	const double     error = std::sqrt(m.kinematicError2 / points);
	const double     typical = m.rootSpeed * m.rootSpeed / (points * points);
	return error <= share * typical ? 0 : error;
}

double residualOf(const ContactProblem& problem) { return residualFromSums(measuresOf(problem)); }

} // namespace rcr

#include "problem/residual.hpp"

namespace rcr {

Measures measuresOf(const ContactProblem& given, double leastResponse)
{
	ContactProblem problem = given;
	updateVelocity(problem);
	Measures m;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const double        w = delassus(problem, c).nn;
		if (w > 0)
			m += measuresOf(problem.impulse[k], relativeVelocity(problem, c), c.bias, c.friction, w,
			        leastResponse);
		if (c.rolls())
			m += rollingMeasures(problem.rollingImpulse[k], rollingVelocity(problem, c),
			        c.rollingFriction * problem.impulse[k].n, rollingResponse(problem, c));
	}
	return m;
}

double driftOf(const Measures& m, double points)
{
	constexpr double share = 0.07; // in packings that are sheared, 0.03 costs three times the sweeps
	const double     error = points > 0 ? std::sqrt(m.kinematicError2 / points) : 0;
	return error * points <= share * m.speed ? 0 : error;
}

double residualOf(const ContactProblem& problem) { return residualFromSums(measuresOf(problem)); }

} // namespace rcr

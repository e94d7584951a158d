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

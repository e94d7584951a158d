#include "problem/residual.hpp"

namespace rcr {

Errors errorsOf(const ContactProblem& given, double velocityFloor)
{
	ContactProblem problem = given;
	updateVelocity(problem);
	Measures m;
	double   freeVelocity2 = 0; // Σ |u_free|² [(m/s)²]
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const double        w = delassus(problem, c).nn;
		if (w <= 0) continue;
		m += measuresOf(problem.impulse[k], relativeVelocity(problem, c), c.bias, c.friction, w);
		freeVelocity2 += square(freeRelativeVelocity(problem, c));
	}
	return errorsFromSums(m, freeVelocity2, velocityFloor);
}

} // namespace rcr

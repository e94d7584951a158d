#include "problem/residual.hpp"

namespace rcr {

namespace {

	struct Sums {
		Measures measures;
		double   freeVelocity2 = 0; // Σ |u_free|² [(m/s)²]
	};

	/// Sums over all points with w_nn > 0. Velocities are recomputed from impulses.
	Sums sumsOf(const ContactProblem& given)
	{
		ContactProblem problem = given;
		updateVelocity(problem);
		Sums sums;
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const ContactPoint& c = problem.points[k];
			const double        w = delassus(problem, c).nn;
			if (w <= 0) continue;
			sums.measures += measuresOf(
			        problem.impulse[k], relativeVelocity(problem, c), c.bias, c.friction, w);
			sums.freeVelocity2 += square(freeRelativeVelocity(problem, c));
		}
		return sums;
	}

} // namespace

double residual(const ContactProblem& problem)
{
	const Measures m = sumsOf(problem).measures;
	return residualFromSums(m.error2, m.impulse2, m.stopping2);
}

double kinematicError(const ContactProblem& problem, double velocityFloor)
{
	const auto [m, freeVelocity2] = sumsOf(problem);
	return kinematicErrorFromSums(m.kinematicError2, m.velocity2, freeVelocity2, velocityFloor);
}

} // namespace rcr

#include "contact_problem.hpp"

namespace rcr {

void updateVelocity(ContactProblem& problem)
{
	problem.velocity = problem.freeVelocity;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		applyImpulse(
		        c,
		        problem.impulse[k],
		        problem.inverseMass[c.body1],
		        problem.inverseMass[c.body2],
		        problem.velocity[c.body1],
		        problem.velocity[c.body2]);
	}
}

} // namespace rcr

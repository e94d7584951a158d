#include "step/restitution.hpp"

#include "problem/coulomb.hpp"

namespace rcr {

bool restrainBounce(Step& step, const StepContact& contact)
{
	bool changed = false;
	for (int k = contact.first; k < contact.first + contact.count && contact.restitution > 0; ++k) {
		ContactPoint& c = step.problem.points[k];
		if (!(c.bias < 0)) continue; // no bounce in this step
		const ContactProblem& problem = step.problem;
		const Impulse         before  = relativeVelocity(c, step.bodies[c.body1].velocity, step.bodies[c.body2].velocity);
		const Impulse         after   = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
		const Delassus        w       = delassus(problem, c);
		const double          share   = passiveShare(w, problem.impulse[k], before, after, c.bias, c.friction);
		c.bias *= share;
		changed |= share < 1;
	}
	return changed;
}

} // namespace rcr

#include "step/energy.hpp"

namespace rcr {

StepEnergy stepEnergy(const Step& step, const std::vector<PlanarVector>& impulses, Vec2 gravity)
{
	StepEnergy            energy;
	const ContactProblem& problem = step.problem;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		// both with the stretch rate at the end and the load, as the work on the cell
		const LocalVector after  = relativeVelocity(problem, c),
		                  before = relativeVelocity(
		                          c, step.stretched(c.body1, step.bodies[c.body1].velocity),
		                          step.stretched(c.body2, step.bodies[c.body2].velocity));
		const double        rubbed = -0.5 * problem.impulse[k].t * (before.t + after.t);
		// restitution reverses the slip: its energy belongs to the impact
		const bool          returns = c.bias < 0 && rubbed < 0;
		(returns ? energy.impact : energy.friction) += rubbed;
		energy.friction -= 0.5 * problem.rollingImpulseOf(k)
		        * (rollingVelocity(problem, c)
		                + rollingVelocity(c, step.bodies[c.body1].velocity,
		                        step.bodies[c.body2].velocity));
		energy.impact -= 0.5 * problem.impulse[k].n * (before.n + after.n);
		// work on the cell, also by the bodies that it moves
		const Vec2 moved = step.cell.drift(problem.placeOf(c.body2) - problem.placeOf(c.body1));
		energy.driven += dot(toCartesian(c.normal, problem.impulse[k]), c.drift + moved);
	}
	for (std::size_t id = 0; id < impulses.size(); ++id) {
		const InverseMass&  inverse = problem.inverseMass[id];
		const PlanarVector before = step.stretched(int(id), step.bodies[id].velocity),
		                   &after = problem.velocity[id];
		if (inverse.x == 0) energy.driven += 0.5 * impulses[id].x * (before.x + after.x);
		if (inverse.y == 0) energy.driven += 0.5 * impulses[id].y * (before.y + after.y);
		if (inverse.rotation == 0)
			energy.driven += 0.5 * impulses[id].rotation * (before.rotation + after.rotation);
		if (step.displacement.empty() || !step.bodies[id].free) continue;
		if (inverse.x > 0) energy.lifted -= gravity.x * step.displacement[id].x / inverse.x;
		if (inverse.y > 0) energy.lifted -= gravity.y * step.displacement[id].y / inverse.y;
	}
	return energy;
}

} // namespace rcr

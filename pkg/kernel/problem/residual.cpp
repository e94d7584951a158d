#include "problem/residual.hpp"

#include "problem/coulomb.hpp"

namespace rcr {

namespace {

	struct Point {
		const ContactProblem& problem;
		const ContactPoint&   c;
		Delassus              w;
		Impulse               p, u, error;
	};

	/// Calls visit(point) for every point with w_nn > 0. Velocities are recomputed from impulses.
	template <class Visit> void forEachPoint(const ContactProblem& given, Visit visit)
	{
		ContactProblem problem = given;
		updateVelocity(problem);
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const ContactPoint& c = problem.points[k];
			const Delassus      w = delassus(problem, c);
			if (w.nn <= 0) continue;
			const Impulse p = problem.impulse[k], u = relativeVelocity(problem, c);
			visit(Point { problem, c, w, p, u,
			        lawError(p, { u.n + c.bias, u.t }, c.friction, w.nn) });
		}
	}

} // namespace

double residual(const ContactProblem& problem)
{
	double error2 = 0, impulse2 = 0, stopping2 = 0;
	forEachPoint(problem, [&](const Point& point) {
		error2 += square(point.error);
		impulse2 += square(point.p);
		const double stopping = (std::abs(point.u.n) + std::abs(point.c.bias)) / point.w.nn;
		stopping2 += stopping * stopping;
	});
	return residualFromSums(error2, impulse2, stopping2);
}

double kinematicError(const ContactProblem& problem, double velocityFloor)
{
	double error2 = 0, velocity2 = 0, freeVelocity2 = 0;
	forEachPoint(problem, [&](const Point& point) {
		error2 += point.w.nn * point.w.nn * square(point.error);
		velocity2 += square(point.u);
		freeVelocity2 += square(freeRelativeVelocity(point.problem, point.c));
	});
	return kinematicErrorFromSums(error2, velocity2, freeVelocity2, velocityFloor);
}

} // namespace rcr

#include "problem/residual.hpp"

#include "problem/coulomb.hpp"

namespace rcr {

namespace {

	struct Point {
		const ContactPoint& c;
		Delassus            w;
		Impulse             p, u, miss; // miss = p − P_K(…)
	};

	/// Calls visit(point) for every point that can carry something, with the velocities computed anew from the impulses.
	template <class Visit> void forEachPoint(const ContactProblem& given, Visit visit)
	{
		ContactProblem problem = given;
		updateVelocity(problem);
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const ContactPoint& c = problem.points[k];
			const Delassus      w = delassus(problem, c);
			if (w.nn <= 0) continue;
			const Impulse p = problem.impulse[k];
			const Impulse u = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
			const Impulse q = projectCone({ p.n - (u.n + c.bias + c.friction * std::abs(u.t)) / w.nn, p.t - u.t / w.nn }, c.friction);
			visit(Point { c, w, p, u, p - q });
		}
	}

} // namespace

double residual(const ContactProblem& problem)
{
	double error2 = 0, impulse2 = 0, stopping2 = 0;
	forEachPoint(problem, [&](const Point& point) {
		error2 += square(point.miss);
		impulse2 += square(point.p);
		const double stopping = (std::abs(point.u.n) + std::abs(point.c.bias)) / point.w.nn;
		stopping2 += stopping * stopping;
	});
	return relativeError(error2, impulse2, stopping2);
}

double violation(const ContactProblem& problem, double rest)
{
	double violation2 = 0, velocity2 = 0, freeVelocity2 = 0;
	forEachPoint(problem, [&](const Point& point) {
		violation2 += point.w.nn * point.w.nn * square(point.miss);
		velocity2 += square(point.u);
		freeVelocity2 += square(freeRelativeVelocity(problem, point.c));
	});
	return kinematicError(violation2, velocity2, freeVelocity2, rest);
}

} // namespace rcr

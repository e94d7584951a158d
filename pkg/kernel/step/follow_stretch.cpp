#include "step/follow_stretch.hpp"

#include <algorithm>
#include <cmath>

namespace rcr {

namespace {

	constexpr double negligible = 0.01; // of the fastest rate of the flow

	/// Σ m r (v − v_start) / Σ m r² along an axis.
	double stretch(const Step& step, double Vec2::*place, double Twist::*speed, double InverseMass::*inverse)
	{
		double moment = 0, inertia = 0;
		for (std::size_t id = 0; id < step.bodies.size(); ++id) {
			const double w = step.problem.inverseMass[id].*inverse, r = step.bodies[id].center.*place;
			if (w == 0) continue;
			moment += r * (step.problem.velocity[id].*speed - step.bodies[id].velocity.*speed) / w;
			inertia += r * r / w;
		}
		return inertia > 0 ? moment / inertia : 0;
	}

} // namespace

bool followStretch(Step& step)
{
	const Vec2 e { stretch(step, &Vec2::x, &Twist::x, &InverseMass::x), stretch(step, &Vec2::y, &Twist::y, &InverseMass::y) };
	double     fastest = 0;
	for (const auto& row : step.rest.gradient)
		for (const double rate : row)
			fastest = std::max(fastest, std::abs(rate));
	if (std::max(std::abs(e.x), std::abs(e.y)) <= negligible * fastest) return false;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const InverseMass& w = step.problem.inverseMass[id];
		for (Twist* v : { &step.bodies[id].velocity, &step.problem.freeVelocity[id] }) {
			if (w.x > 0) v->x += e.x * step.bodies[id].center.x;
			if (w.y > 0) v->y += e.y * step.bodies[id].center.y;
		}
	}
	return true;
}

} // namespace rcr

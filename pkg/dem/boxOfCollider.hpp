// The box in which the collider knows a body.
#pragma once

#include <core/Bound.hpp>
#include <core/State.hpp>

#include "../kernel/step/step.hpp"

namespace yade {

/// Does a grain at this velocity, with its alert distance, reach out of its box within the step? Then the collider has not foreseen all that it meets.
inline bool outruns(const rcr::StepBody& b, const rcr::Twist& v, double dt, const State& state, const Bound& bound)
{
	const double   reach = b.radius + rcr::alertDistance(b.shape, v, dt);
	const Vector3r moved = state.pos + dt * Vector3r(v.x, v.y, 0) - bound.refPos;
	const double   half  = 0.5 * double(bound.max[0] - bound.min[0]);
	return std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > half;
}

} // namespace yade

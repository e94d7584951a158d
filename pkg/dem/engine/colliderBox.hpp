// Bounding box of a body in the collider.
#pragma once

#include <core/Bound.hpp>

#include "kernel/step/missed_contacts.hpp"

namespace yade {

/// A grain at this position reaches out of its box with the alert distance of this velocity, so the collider may miss contacts.
inline bool leavesBox(const rcr::StepBody& b, const Vector3r& at, const rcr::Twist& v, double dt, const Bound& bound)
{
	const double   reach = b.radius + rcr::alertDistance(b.shape, v, dt);
	const Vector3r moved = at - bound.refPos;
	const double   half  = 0.5 * double(bound.max[0] - bound.min[0]);
	return std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > half;
}

} // namespace yade

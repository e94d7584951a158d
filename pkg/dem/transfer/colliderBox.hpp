// Bounding box of a body in the collider.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/detection/missed_contacts.hpp"

namespace yade {

/// A grain at this position reaches out of its box with the alert distance of this velocity, so the
/// collider may miss contacts.
inline bool grainLeavesBox(const rcr::StepBody& b, const Vector3r& at, const rcr::Twist& v,
        double dt, const Bound& bound)
{
	const double   reach = b.radius + rcr::alertDistance(b.shape, v, dt);
	const Vector3r moved = at - bound.refPos;
	const double   half  = 0.5 * double(bound.max[0] - bound.min[0]);
	return std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > half;
}

/// An obstacle at this pose reaches out of its box with this distance.
inline bool obstacleLeavesBox(
        const rcr::PlanarShape& shape, rcr::Pose at, double reach, const Bound& bound)
{
	constexpr double infinite = std::numeric_limits<double>::infinity();
	if (shape.kind == rcr::PlanarShape::segment) at = rcr::segmentPose(shape, at);
	rcr::Vec2 half = rcr::halfExtent(shape, at.axis);
	if (shape.kind == rcr::PlanarShape::wall)
		half = shape.axis == 0 ? rcr::Vec2 { 0, -infinite } : rcr::Vec2 { -infinite, 0 };
	const auto out = [&](int axis, double center, double extent) {
		return center + extent + reach > double(bound.max[axis])
		        || center - extent - reach < double(bound.min[axis]);
	};
	return out(0, at.center.x, half.x) || out(1, at.center.y, half.y);
}

} // namespace yade

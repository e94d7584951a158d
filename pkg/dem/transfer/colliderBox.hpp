// Bounding box of a body in the collider.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/detection/undetected_contacts.hpp"

namespace yade {

/// Returns true if a grain at this position, enlarged by the alert distance of this velocity,
/// leaves its box. The collider may then not list all its contacts.
inline bool grainLeavesBox(const rcr::StepBody& b, const Vector3r& at, const rcr::Twist& v,
        double dt, const Bound& bound)
{
	const double   extent = b.radius + rcr::alertDistance(b.shape, v, dt);
	const Vector3r moved  = at - bound.refPos;
	const double   half   = 0.5 * double(bound.max[0] - bound.min[0]);
	return std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + extent > half;
}

/// Returns true if an obstacle at this pose, enlarged by `margin` [m], leaves its box.
inline bool obstacleLeavesBox(
        const rcr::PlanarShape& shape, const rcr::Pose& at, double margin, const Bound& bound)
{
	const rcr::BoundingBox box = rcr::boundsOf(shape, at);
	const auto             out = [&](int axis, double center, double extent) {
        return center + extent + margin > double(bound.max[axis])
                || center - extent - margin < double(bound.min[axis]);
	};
	return out(0, box.center.x, box.half.x) || out(1, box.center.y, box.half.y);
}

} // namespace yade

// Shape of a YADE body in the plane of the grains.
#pragma once

#include "kernel/detection/undetected_contacts.hpp"
#include "dem/shapes/Rcr.hpp"
#include "dem/shapes/plane.hpp"

namespace yade::plane {

/// Shape in the plane at height z; kind none if it is unsupported or does not reach the plane.
rcr::PlanarShape shapeOf(const Shape&, const State&, Real z);

/// Rotation of a body; 0 for a segment, whose end points contain the rotation.
inline rcr::Turn turnOf(const rcr::PlanarShape& shape, const State& state)
{
	return shape.kind == rcr::PlanarShape::segment
	        ? rcr::Turn {}
	        : rcr::Turn { double(state.ori.w()), double(state.ori.z()) };
}

} // namespace yade::plane

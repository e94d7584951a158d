// What a YADE body looks like in the plane of the grains.
#pragma once

#include <core/Body.hpp>
#include <core/State.hpp>

#include "../kernel/step/missed_contacts.hpp"
#include "Rcr.hpp"
#include "plane.hpp"

namespace yade {
namespace plane {

	/// The shape in the plane at this z; of kind none where it is not served or does not reach the plane.
	rcr::PlanarShape shapeOf(const Shape&, const State&, Real z);

	/// Centre and turn. A segment is given in the directions of space, so its body is not turned.
	inline rcr::Turn turnOf(const rcr::PlanarShape& shape, const State& state)
	{
		return shape.kind == rcr::PlanarShape::segment ? rcr::Turn {} : rcr::Turn { double(state.ori.w()), double(state.ori.z()) };
	}

} // namespace plane
} // namespace yade

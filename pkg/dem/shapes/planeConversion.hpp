// Conversions between YADE's three dimensions and the plane z = const of the grains.
#pragma once

#include "dem/shapes/Rcr.hpp"
#include "kernel/detection/late_contacts.hpp"
#include "kernel/step/leapfrog.hpp"

namespace yade::plane {

inline rcr::Vec2 toPlane(const Vector3r& v) { return { double(v[0]), double(v[1]) }; }
inline Vector3r  toSpace(rcr::Vec2 v) { return Vector3r(v.x, v.y, 0); }

inline rcr::PlanarVector velocityOf(const State& state)
{
	return { double(state.vel[0]), double(state.vel[1]), double(state.angVel[2]) };
}

inline rcr::Inertia inertiaOf(const State& s)
{
	const auto free = [&](unsigned dof) { return !(s.blockedDOFs & dof); };
	return { double(s.mass), double(s.inertia[2]), free(State::DOF_X), free(State::DOF_Y),
		free(State::DOF_RZ) };
}

inline rcr::Flow flowOf(const Matrix3r& gradient)
{
	return { { { double(gradient(0, 0)), double(gradient(0, 1)) },
		    { double(gradient(1, 0)), double(gradient(1, 1)) } } };
}

/// Velocity gradient that NewtonIntegrator will apply next [1/s].
Matrix3r nextGradient(const Cell&);

/// A vector as a sum of edges of the cell, rounded; 0 along z.
Vector3i cellsOf(const Cell&, rcr::Vec2);

/// The periodic cell of a scene with nextGradient.
rcr::PeriodicCell cellOf(const Scene&);

/// Shape in the plane at height z; kind none if it is unsupported or does not reach the plane.
rcr::PlanarShape shapeOf(const Shape&, const State&, Real z);

/// Rotation of a body. Segments have 0, since `cut` rotates their ends.
inline rcr::Turn turnOf(const rcr::PlanarShape& shape, const State& state)
{
	return shape.kind == rcr::PlanarShape::segment
	        ? rcr::Turn {}
	        : rcr::Turn { double(state.ori.w()), double(state.ori.z()) };
}

} // namespace yade::plane

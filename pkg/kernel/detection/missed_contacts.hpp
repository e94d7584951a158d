// Contacts that form within a step although its detection did not find them.
//
// Detection covers gaps up to e₁ + e₂, the reaches of the two bodies. The reach of a body is its
// alert distance, which follows from its velocity at the beginning of the step:
//
//   e = 2 dt (|v| + |ω| R), for a grain at least 0.01 R'
//
// For a wall, |v| is its speed along its normal. A body that is released or hit may move further.
// After the solve, the reach of a free body whose path exceeds e is widened to e + 1.5 path. If an
// undetected gap then closes beyond the slop, all contacts that the wider reach finds are added.
// The step is then solved again, up to its limit of passes. A gap closes on its tangent plane, or,
// with a large displacement, on the curved paths of the bodies.
#pragma once

#include <functional>

#include "step/step.hpp"

namespace rcr {

/// Distance within which contacts of a body with this velocity are detected [m].
inline double alertDistance(const PlanarShape& shape, const Twist& v, double dt)
{
	switch (shape.kind) {
		case PlanarShape::wall: return 2 * dt * std::abs(shape.axis == 0 ? v.x : v.y);
		case PlanarShape::disc:
		case PlanarShape::stadium:
			return std::max(0.01 * shape.halfWidth, 2 * dt * speed(v, shape.radius()));
		default: return 2 * dt * speed(v, shape.radius());
	}
}

/// Returns true if masks, clumps and engines of the simulation allow a contact of two bodies that
/// do not touch yet.
using MayMeet = std::function<bool(int body1, int body2)>;

/// Before the solve, detects contacts of bodies whose pairs in the simulation may be incomplete.
/// Collects them in step.updated and returns true if there are any; addUpdatedContacts must then
/// follow.
bool findUnlistedContacts(Step&, const std::vector<std::int32_t>& bodies, const MayMeet&);

/// Reach of a body in this step so far [m].
double reachOf(const Step&, std::size_t id);

/// Collects in step.updated the contacts that the solved step finds with a widened reach. Returns
/// true if one of them closes beyond the slop; addUpdatedContacts must then follow.
bool findMissedContacts(Step&, const MayMeet&);

/// In the solved step, two bodies may meet at two places of a periodic cell: their radii and paths
/// exceed half of its smallest height. Only the contact of the nearest images is detected.
bool mayMeetTwoImages(const Step&);

/// Adds step.updated to the contacts, points and forces of the step, and moves it to step.added.
/// The caller sets friction and restitution of new contacts before.
void addUpdatedContacts(Step&);

} // namespace rcr

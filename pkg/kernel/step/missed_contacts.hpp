// Contacts that a step reaches although its beginning did not see them.
//
// How far ahead contacts are seen follows from the speeds at the beginning of a step:
//
//   reach of a pair  e₁ + e₂,   e = max(0.01 R', 2 dt (|v| + |ω| R)) of a grain,  2 dt (|v| + |ω| R) of an obstacle
//
// A body that is released or hit goes further. Once the step is solved, how far is known: bodies that outrun their alert distance
// look again, by 1.5 times the way found, and where a gap that the law did not know would close beyond the slop, all contacts
// that were seen so are taken in and the step is to be solved once more.
#pragma once

#include <functional>

#include "step/step.hpp"

namespace rcr {

/// How far ahead contacts of a body with this velocity are looked for [m].
inline double alertDistance(const PlanarShape& shape, const Twist& v, double dt)
{
	switch (shape.kind) {
		case PlanarShape::wall: return 2 * dt * std::abs(shape.axis == 0 ? v.x : v.y);
		case PlanarShape::disc:
		case PlanarShape::stadium: return std::max(0.01 * shape.halfWidth, 2 * dt * speed(v, shape.radius()));
		default: return 2 * dt * speed(v, shape.radius());
	}
}

/// Whether two bodies that do not touch yet may meet at all, in the simulation's rules.
using MayMeet = std::function<bool(int body1, int body2)>;

/// How far a body has looked for contacts in this step so far [m].
double reachOf(const Step&, std::size_t id);

/// Looks at the solved step and adds pairs with other points than known to step.grown. True if one of them closes beyond the slop:
/// then all are to be taken in.
bool findMissedContacts(Step&, const MayMeet&);

/// Moves step.grown to step.taken: contacts, their points, and the forces to start from. Friction and restitution of new ones must
/// be set there.
void takeInGrownContacts(Step&);

} // namespace rcr

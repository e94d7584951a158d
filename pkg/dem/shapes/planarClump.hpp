// Clumps that stay in the plane.
#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade {

/// Joins bodies into a clump with a centre [m], a mass [kg] and a moment of inertia about z [kg
/// m²], per unit depth. Returns its id. YADE's own function rotates clumps to principal axes that
/// may lie out of the plane.
int planarClump(const boost::python::list& ids, double x, double y, double mass, double inertia);

} // namespace yade

// A clump that stays in the plane.
#pragma once

#include <boost/python.hpp>

namespace yade {

/// Joins bodies of the scene into a clump with this centre [m], mass [kg] and moment of inertia about z [kg m²], per unit depth; returns its id.
/// YADE's own clumps are turned to the principal axes of their inertia, which may lie out of the plane.
int planarClump(const boost::python::list& ids, double x, double y, double mass, double inertia);

} // namespace yade

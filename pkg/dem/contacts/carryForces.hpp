// Carries the forces of a contact from the points of the last step to those of this step
// (kernel/step/carry_forward.hpp).
//
// For physics with `points`, `along`, `force1` and `force2`: CdPhys, whose forces start the
// iterations, and RcrFrictPhys, whose forces are those of the springs.
#pragma once

#include "kernel/step/carry_forward.hpp"
#include "dem/contacts/RcrGeom.hpp"

namespace yade {

template <class Phys> inline void carryForces(const RcrGeom& geom, Phys& phys)
{
	rcr::carryForward(phys.points, phys.along, geom.points, geom.along, phys.force1, phys.force2,
	        Vector2r(Vector2r::Zero()));
	phys.points = geom.points;
	phys.along  = geom.along;
}

} // namespace yade

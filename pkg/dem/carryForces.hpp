// Hands the forces of the last step's points on to this step's (step/pairs.hpp).
//
// For physics with `points`, `along`, `force1` and `force2`: CdPhys, where these start the iterations, and RcrFrictPhys,
// where they hold the stretch of the tangential springs.
#pragma once

#include "../kernel/step/pairs.hpp"
#include "RcrGeom.hpp"

namespace yade {

template <class Phys> inline void carryForces(const RcrGeom& geom, Phys& phys)
{
	rcr::carryForward(phys.points, phys.along, geom.points, geom.along, phys.force1, phys.force2, Vector2r(Vector2r::Zero()));
	phys.points = geom.points;
	phys.along  = geom.along;
}

} // namespace yade

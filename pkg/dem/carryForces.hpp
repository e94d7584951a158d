// Hands the forces of the last step's points on to this step's: two points keep their order along the particle; where one
// becomes two or two one, the nearest takes over, since the other has just opened or closed.
//
// For physics with `points`, `along`, `force1` and `force2`: CdPhys, where these start the iterations, and RcrFrictPhys,
// where they hold the stretch of the tangential springs.
#pragma once

#include "RcrGeom.hpp"

namespace yade {

template <class Phys> inline void carryForces(const RcrGeom& geom, Phys& phys)
{
	if (phys.points == 1 && geom.points == 2) {
		const bool second = math::abs(geom.along[1] - phys.along[0]) < math::abs(geom.along[0] - phys.along[0]);
		phys.force2       = second ? phys.force1 : Vector2r(Vector2r::Zero());
		if (second) phys.force1 = Vector2r::Zero();
	} else if (phys.points == 2 && geom.points == 1) {
		if (math::abs(phys.along[1] - geom.along[0]) < math::abs(phys.along[0] - geom.along[0])) phys.force1 = phys.force2;
		phys.force2 = Vector2r::Zero();
	}
	phys.points = geom.points;
	phys.along  = geom.along;
}

} // namespace yade

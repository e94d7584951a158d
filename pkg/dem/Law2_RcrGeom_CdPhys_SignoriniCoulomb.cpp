#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"

#include "carryForces.hpp"

namespace yade {

YADE_PLUGIN((Law2_RcrGeom_CdPhys_SignoriniCoulomb));

bool Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction*)
{
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	if (geom.points == 0) return false;
	carryForces(geom, static_cast<CdPhys&>(*iphys));
	return true;
}

} // namespace yade

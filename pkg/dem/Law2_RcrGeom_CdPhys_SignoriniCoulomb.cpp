#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"

#include <core/Scene.hpp>

#include "Gate.hpp"
#include "carryForces.hpp"
#include "refuseLater.hpp"

namespace yade {

YADE_PLUGIN((Law2_RcrGeom_CdPhys_SignoriniCoulomb));

bool Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction*)
{
	if (asked_.exchange(scene->iter) != scene->iter) {
		const std::string told = gate::unsolved(*scene);
		if (!told.empty()) refuseLater(told);
	}
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	if (geom.points == 0) return false;
	carryForces(geom, static_cast<CdPhys&>(*iphys));
	return true;
}

} // namespace yade

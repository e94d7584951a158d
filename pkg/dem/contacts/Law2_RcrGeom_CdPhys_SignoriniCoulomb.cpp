#include "dem/contacts/Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"

#include "dem/validation/validation.hpp"
#include "dem/validation/deferredError.hpp"

namespace yade {

bool Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(
        shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction*)
{
	if (checked_.exchange(scene->iter) != scene->iter) {
		const std::string message = validation::missingSolver(*scene);
		if (!message.empty()) deferError(message);
	}
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	if (geom.points == 0) return false;
	carryForces(geom, static_cast<CdPhys&>(*iphys));
	return true;
}

} // namespace yade

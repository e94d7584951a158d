#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"

#include <algorithm>

#include <core/Scene.hpp>

#include "ContactDynamics.hpp"
#include "carryForces.hpp"
#include "refuseLater.hpp"

namespace yade {

YADE_PLUGIN((Law2_RcrGeom_CdPhys_SignoriniCoulomb));

namespace {

	bool solved(const Scene& scene)
	{
		return std::any_of(scene.engines.begin(), scene.engines.end(), [](const auto& e) { return !e->dead && dynamic_cast<const ContactDynamics*>(e.get()); });
	}

} // namespace

bool Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction*)
{
	if (asked_.exchange(scene->iter) != scene->iter && !solved(*scene)) // the gate lives in ContactDynamics, which somebody has taken away
		refuseLater("O.engines holds no ContactDynamics that is not dead, so rigid contacts carry nothing; leave it alive between the InteractionLoop and the NewtonIntegrator.");
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	if (geom.points == 0) return false;
	carryForces(geom, static_cast<CdPhys&>(*iphys));
	return true;
}

} // namespace yade

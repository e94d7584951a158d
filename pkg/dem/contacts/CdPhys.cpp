#include "dem/contacts/CdPhys.hpp"

#include "dem/validation/deferredError.hpp"
#include "dem/validation/validation.hpp"

namespace yade {

void Ip2_FrictMat_FrictMat_CdPhys::go(const shared_ptr<Material>& material1,
        const shared_ptr<Material>& material2, const shared_ptr<Interaction>& interaction)
{
	if (interaction->phys) return;
	const FrictMat& one  = static_cast<const FrictMat&>(*material1);
	const FrictMat& two  = static_cast<const FrictMat&>(*material2);
	auto            phys = boost::make_shared<CdPhys>();

	constexpr Real none  = std::numeric_limits<double>::quiet_NaN();
	const Real     angle = frictAngle
	            ? (*frictAngle)(one.id, two.id, one.frictionAngle, two.frictionAngle)
	            : math::min(one.frictionAngle, two.frictionAngle);
	// checkPhys refuses NaN, outside of the parallel loop
	phys->tangensOfFrictionAngle = angle >= 0 && angle < 0.5 * Mathr::PI ? math::tan(angle) : none;
	if (restitution) {
		// materials have no restitution, of which a MatchMaker could take a mean
		try {
			phys->restitution = (*restitution)(one.id, two.id, none, none);
		} catch (const std::invalid_argument&) {
			phys->restitution = none;
		}
	}
	interaction->phys = phys;
}

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

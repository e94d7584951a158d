#include "dem/contacts/CdPhys.hpp"

#include "dem/contacts/sceneRules.hpp"
#include "dem/errors/deferredError.hpp"

namespace yade {

rcr::ContactLaw CdPhys::law() const
{
	return { double(tangensOfFrictionAngle), double(restitution), double(adhesion),
		double(rollingFriction) };
}

void CdPhys::setLaw(const rcr::ContactLaw& law)
{
	tangensOfFrictionAngle = law.friction;
	restitution            = law.restitution;
	adhesion               = law.adhesion;
	rollingFriction        = law.rollingFriction;
}

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
	// materials have no such coefficients, of which a MatchMaker could take a mean
	const auto match = [&](const shared_ptr<MatchMaker>& maker, Real& coefficient) {
		if (!maker) return;
		try {
			coefficient = (*maker)(one.id, two.id, none, none);
		} catch (const std::invalid_argument&) {
			coefficient = none;
		}
	};
	match(restitution, phys->restitution);
	match(adhesion, phys->adhesion);
	match(rollingFriction, phys->rollingFriction);
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
	CdPhys& phys = static_cast<CdPhys&>(*iphys);
	if (phys.points != 1 || geom.points != 1) phys.rollingMoment = 0;
	carryForces(geom, phys);
	return true;
}

} // namespace yade

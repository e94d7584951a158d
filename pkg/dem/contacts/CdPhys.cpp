#include "dem/contacts/CdPhys.hpp"

namespace yade {

void Ip2_FrictMat_FrictMat_CdPhys::go(const shared_ptr<Material>& material1,
        const shared_ptr<Material>& material2, const shared_ptr<Interaction>& interaction)
{
	if (interaction->phys) return;
	const FrictMat& one  = static_cast<const FrictMat&>(*material1);
	const FrictMat& two  = static_cast<const FrictMat&>(*material2);
	auto            phys = boost::make_shared<CdPhys>();

	const Real angle             = frictAngle
	                    ? (*frictAngle)(one.id, two.id, one.frictionAngle, two.frictionAngle)
	                    : math::min(one.frictionAngle, two.frictionAngle);
	phys->tangensOfFrictionAngle = math::tan(angle);
	if (restitution) phys->restitution = (*restitution)(one.id, two.id, 0, 0);
	interaction->phys = phys;
}

} // namespace yade

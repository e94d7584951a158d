#include "dem/transfer/contactLaw.hpp"

namespace yade {

ContactLaw contactLaw(Scene& scene, const InteractionLoop& loop, Body::id_t id1, Body::id_t id2)
{
	shared_ptr<Material>&one = (*scene.bodies)[id1]->material,
	&two                     = (*scene.bodies)[id2]->material;
	const auto  scratch = boost::make_shared<Interaction>(id1, id2);
	bool        swap    = false;
	loop.physDispatcher->getFunctor2D(one, two, swap)->go(one, two, scratch);
	const CdPhys* phys = dynamic_cast<const CdPhys*>(scratch->phys.get());
	if (!phys)
		validation::refuse("the contact of ", validation::bodyNames({ id1, id2 }),
		        " gets the physics ",
		        scratch->phys ? scratch->phys->getClassName() : std::string("None"),
		        " from the Ip2 functor of the materials ", one->getClassName(), " and ",
		        two->getClassName(),
		        "; expected CdPhys: use Ip2_FrictMat_FrictMat_CdPhys for these materials.");
	validation::checkPhys(*phys, id1, id2);
	return { double(phys->tangensOfFrictionAngle), double(phys->restitution) };
}

bool allowsContact(Scene& scene, const validation::Engines& engines, Body::id_t id1, Body::id_t id2)
{
	if (!validation::mayCollide(scene, *engines.collider, id1, id2)) return false;
	Body &one = *(*scene.bodies)[id1], &two = *(*scene.bodies)[id2];
	if (!one.isBounded() || !two.isBounded()) return false;
	bool       swap;
	const bool supported
	        = bool(engines.loop->geomDispatcher->getFunctor2D(one.shape, two.shape, swap));
	if (!supported) validation::checkSupported(scene, id1, id2);
	return supported && dynamic_cast<const FrictMat*>(one.material.get())
	        && dynamic_cast<const FrictMat*>(two.material.get());
}

} // namespace yade

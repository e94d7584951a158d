#include "dem/transfer/newContacts.hpp"

namespace yade {

/// Coefficients of a new contact by the Ip2 functor of the scene.
static rcr::ContactLaw newContactLaw(
        Scene& scene, const InteractionLoop& loop, Body::id_t id1, Body::id_t id2)
{
	shared_ptr<Material>& one = (*scene.bodies)[id1]->material;
	shared_ptr<Material>& two = (*scene.bodies)[id2]->material;
	const auto scratch = boost::make_shared<Interaction>(id1, id2);
	bool       swap    = false;
	loop.physDispatcher->getFunctor2D(one, two, swap)->go(one, two, scratch);
	const CdPhys* phys = dynamic_cast<const CdPhys*>(scratch->phys.get());
	if (!phys)
		errors::refuse("the contact of ", errors::bodyNames({ id1, id2 }),
		        " gets the physics ",
		        scratch->phys ? scratch->phys->getClassName() : std::string("None"),
		        " from the Ip2 functor of the materials ", one->getClassName(), " and ",
		        two->getClassName(),
		        "; expected CdPhys: use Ip2_FrictMat_FrictMat_CdPhys for these materials.");
	validation::checkPhys(*phys, id1, id2);
	return phys->law();
}

static rcr::ContactFilter contactFilter(Scene& scene, const validation::Engines& engines)
{
	return [&](int id1, int id2) {
		if (!validation::mayCollide(scene, *engines.collider, id1, id2)) return false;
		Body &one = *(*scene.bodies)[id1], &two = *(*scene.bodies)[id2];
		bool  swap;
		if (!engines.loop->geomDispatcher->getFunctor2D(one.shape, two.shape, swap)) {
			validation::refuseUnsupported(scene, id1, id2);
			return false;
		}
		return validation::materialError(scene, id1, id2).empty();
	};
}

rcr::NewContacts newContacts(Scene& scene, const validation::Engines& engines)
{
	return { contactFilter(scene, engines), [&](int id1, int id2) {
		        return newContactLaw(scene, *engines.loop, id1, id2);
	        } };
}

void addUnlistedContacts(Scene& scene, const validation::Engines& engines, const Engine& solver,
        rcr::ThreadTeam& team, SceneHandles& handles, rcr::Neighbors& neighbors, rcr::Step& step)
{
	const std::vector<Body::id_t> changed
	        = handles.pairExclusions.restartIfChanged(scene, *engines.collider);
	const std::string error = changed.empty() && !handles.pairExclusions.hasReplaced()
	        ? std::string() : validation::sceneError(scene);
	if (!error.empty()) errors::refuse(error);
	for (Body::id_t id : changed)
		handles.mayLackContacts[id] = true;
	// engines and scripts after the InteractionLoop may have set velocities
	bool       afterLoop = false;
	const auto markUnlisted = [&](Body::id_t id) {
		if (id >= 0 && std::size_t(id) < handles.mayLackContacts.size())
			handles.mayLackContacts[id] = bool(handles.state[id]);
	};
	for (const auto& engine : scene.engines) {
		if (engine.get() == &solver) break;
		afterLoop |= engine.get() == engines.loop;
		if (!afterLoop || engine->dead) continue;
		if (validation::isKinematic(*engine)) {
			const auto& ids = static_cast<const PartialEngine&>(*engine).ids;
			std::for_each(ids.begin(), ids.end(), markUnlisted);
		}
		const auto* script = dynamic_cast<const PeriodicEngine*>(engine.get());
		if (script && script->nDone > 0 && script->iterLast == scene.iter)
			for (std::size_t id = 0; id < handles.mayLackContacts.size(); ++id)
				markUnlisted(Body::id_t(id));
	}
	std::vector<std::int32_t> unlisted;
	for (std::size_t id = 0; id < handles.mayLackContacts.size(); ++id)
		if (handles.mayLackContacts[id]) unlisted.push_back(std::int32_t(id));
	if (unlisted.empty()) return;
	const rcr::NewContacts host = newContacts(scene, engines);
	if (rcr::findUnlistedContacts(step, unlisted, { neighbors, team, host.allows }))
		rcr::addFoundContacts(step, host);
}

} // namespace yade

// Contacts that ContactDynamics adds to those of the InteractionLoop.
#include <algorithm>

#include <pkg/common/Collider.hpp>
#include <pkg/common/KinematicEngines.hpp>
#include <pkg/common/PeriodicEngines.hpp>

#include "dem/engine/ContactDynamics.hpp"
#include "kernel/detection/missed_contacts.hpp"

namespace yade {

namespace {
	rcr::MayMeet ruleOfMeeting(Scene& scene, const validation::Engines& engines)
	{
		return [&](int id1, int id2) { return mayMeet(scene, engines, id1, id2); };
	}
}

bool ContactDynamics::findMissedContacts(const validation::Engines& engines)
{
	return rcr::findMissedContacts(step_, ruleOfMeeting(*scene, engines));
}

/// Completes the contacts within reach, so that they do not depend on when the collider ran.
void ContactDynamics::addUnlistedContacts(const validation::Engines& engines)
{
	// Ig2 functors have used the velocities before these engines and scripts set them.
	bool       afterLoop = false;
	const auto complete  = [&](Body::id_t id) {
        if (id >= 0 && std::size_t(id) < handles_.isUnlisted.size())
            handles_.isUnlisted[id] = bool(handles_.state[id]);
	};
	for (const auto& engine : scene->engines) {
		if (engine.get() == this) break;
		afterLoop |= engine.get() == engines.loop;
		if (!afterLoop || engine->dead) continue;
		if (const auto* kinematic = dynamic_cast<const KinematicEngine*>(engine.get()))
			std::for_each(kinematic->ids.begin(), kinematic->ids.end(), complete);
		const auto* script = dynamic_cast<const PeriodicEngine*>(engine.get());
		if (script && script->nDone > 0 && script->iterLast == scene->iter)
			for (std::size_t id = 0; id < handles_.isUnlisted.size(); ++id)
				complete(Body::id_t(id));
	}
	std::vector<std::int32_t> unlisted;
	for (std::size_t id = 0; id < handles_.isUnlisted.size(); ++id)
		if (handles_.isUnlisted[id]) unlisted.push_back(std::int32_t(id));
	if (unlisted.empty()) return;
	if (rcr::findUnlistedContacts(step_, unlisted, ruleOfMeeting(*scene, engines)))
		addUpdatedContacts(engines);
}

bool ContactDynamics::addMissedContacts(const validation::Engines& engines)
{
	if (!findMissedContacts(engines)) return false;
	addUpdatedContacts(engines);
	return true;
}

void ContactDynamics::addUpdatedContacts(const validation::Engines& engines)
{
	for (rcr::UpdatedContact& contact : step_.updated) {
		if (contact.known) continue;
		const ContactLaw law = contactLaw(*scene, *engines.loop, contact.body1, contact.body2);
		contact.friction = law.friction, contact.restitution = law.restitution;
	}
	rcr::addUpdatedContacts(step_);
}

/// Makes the collider list all pairs again. It checks masks only when boxes begin to overlap.
void ContactDynamics::restartCollider(const validation::Engines& engines)
{
	engines.collider->invalidatePersistentData();
	scene->doSort = true;
}

} // namespace yade

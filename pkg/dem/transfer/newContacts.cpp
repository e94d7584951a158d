#include "dem/transfer/newContacts.hpp"

#include <algorithm>

#include "kernel/detection/missed_contacts.hpp"

namespace yade {

namespace {
	rcr::MayMeet ruleOfMeeting(Scene& scene, const validation::Engines& engines)
	{
		return [&](int id1, int id2) { return mayMeet(scene, engines, id1, id2); };
	}

	void addUpdatedContacts(Scene& scene, const validation::Engines& engines, rcr::Step& step)
	{
		for (rcr::UpdatedContact& contact : step.updated) {
			if (contact.known) continue;
			const ContactLaw law = contactLaw(scene, *engines.loop, contact.body1, contact.body2);
			contact.friction = law.friction, contact.restitution = law.restitution;
		}
		rcr::addUpdatedContacts(step);
	}
} // namespace

bool findMissedContacts(Scene& scene, const validation::Engines& engines, rcr::Step& step)
{
	return rcr::findMissedContacts(step, ruleOfMeeting(scene, engines));
}

void addUnlistedContacts(Scene& scene, const validation::Engines& engines, const Engine& solver,
        SceneHandles& handles, rcr::Step& step)
{
	const std::vector<Body::id_t> changed = handles.pairRules.update(scene, *engines.collider);
	const std::string wrong = changed.empty() ? std::string() : validation::refusal(scene);
	if (!wrong.empty()) validation::refuse(wrong);
	for (Body::id_t id : changed)
		handles.isUnlisted[id] = true;
	// Ig2 functors have used the velocities before these engines and scripts set them.
	bool       afterLoop = false;
	const auto complete  = [&](Body::id_t id) {
        if (id >= 0 && std::size_t(id) < handles.isUnlisted.size())
            handles.isUnlisted[id] = bool(handles.state[id]);
	};
	for (const auto& engine : scene.engines) {
		if (engine.get() == &solver) break;
		afterLoop |= engine.get() == engines.loop;
		if (!afterLoop || engine->dead) continue;
		if (const auto* kinematic = dynamic_cast<const KinematicEngine*>(engine.get()))
			std::for_each(kinematic->ids.begin(), kinematic->ids.end(), complete);
		const auto* script = dynamic_cast<const PeriodicEngine*>(engine.get());
		if (script && script->nDone > 0 && script->iterLast == scene.iter)
			for (std::size_t id = 0; id < handles.isUnlisted.size(); ++id)
				complete(Body::id_t(id));
	}
	std::vector<std::int32_t> unlisted;
	for (std::size_t id = 0; id < handles.isUnlisted.size(); ++id)
		if (handles.isUnlisted[id]) unlisted.push_back(std::int32_t(id));
	if (unlisted.empty()) return;
	if (rcr::findUnlistedContacts(step, unlisted, ruleOfMeeting(scene, engines)))
		addUpdatedContacts(scene, engines, step);
}

bool addMissedContacts(Scene& scene, const validation::Engines& engines, rcr::Step& step)
{
	if (!findMissedContacts(scene, engines, step)) return false;
	addUpdatedContacts(scene, engines, step);
	return true;
}

} // namespace yade

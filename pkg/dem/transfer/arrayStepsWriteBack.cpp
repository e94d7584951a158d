// Copies the state of steps in arrays to YADE's objects.
#include "dem/transfer/ArraySteps.hpp"
#include "dem/transfer/prefetch.hpp"
#include "dem/transfer/scatter.hpp"

namespace yade {

void ArraySteps::writeBack(
        Scene& scene, rcr::ThreadTeam& team, SceneHandles& handles, const rcr::Step& step)
{
	if (!active_) return;
	active_      = false;
	scene.doSort = true; // the collider has not run during the steps in arrays
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		prefetch<State>(handles.state[indexAhead(id, step.bodies.size())]);
		State* s = handles.state[id];
		if (!s || isSynced_[id]) return;
		const rcr::StepBody&     body = step.bodies[id];
		const rcr::PlanarVector& v    = step.overdamped ? endVelocity_[id] : body.velocity;
		// a state that a script has written meanwhile stays
		const Motion before = written_[id], now = motionOf(*s);
		if (now.center == before.center) s->pos[0] = body.center.x, s->pos[1] = body.center.y;
		if (now.turn == before.turn) s->ori.w() = body.turn.w, s->ori.z() = body.turn.z;
		if (now.velocity == before.velocity)
			s->vel[0] = v.x, s->vel[1] = v.y, s->angVel[2] = v.rotation;
	});

	std::vector<Interaction*> interaction(pairs_.all.size());
	std::vector<char>         lasts(handles.sorted.size());
	// false for a new pair after an error
	const auto                made = [](const rcr::Pair& pair) {
        return pair.pointCount > 0 && (pair.handleIndex >= 0 || pair.formedAt >= 0);
	};
	for (std::size_t k = 0; k < interaction.size(); ++k) {
		const int index = pairs_.all[k].handleIndex;
		if (!made(pairs_.all[k]) || index < 0) continue;
		lasts[index]   = true;
		interaction[k] = handles.sorted[index].interaction;
	}
	for (std::size_t k = 0; k < lasts.size(); ++k)
		if (!lasts[k] && handles.sorted[k].interaction) handles.sorted[k].interaction->reset();
	for (std::size_t k = 0; k < interaction.size(); ++k)
		if (made(pairs_.all[k]) && !interaction[k])
			interaction[k] = &interactionOf(scene, pairs_.all[k], {});
	std::vector<SceneHandles::Contact> contacts(interaction.size());
	team.forEach(interaction.size(), [&](std::size_t k) {
		if (const Interaction* later = interaction[indexAhead(k, interaction.size())]) {
			prefetch<RcrGeom>(later->geom.get());
			prefetch<CdPhys>(later->phys.get());
		}
		if (!interaction[k]) return;
		const rcr::Pair& pair = pairs_.all[k];
		contacts[k] = writeContact(*interaction[k], pair, pairs_.manifold[k], step,
		        step.bodies[pair.body2].pose());
		const rcr::Manifold& manifold = pairs_.manifold[k];
		writeForce(*contacts[k].phys, pair.force,
		        { manifold.points[0].normal, manifold.points[1].normal });
	});
	handles.sorted.swap(contacts);
}

} // namespace yade

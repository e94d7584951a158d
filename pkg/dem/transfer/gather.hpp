// First stage of a step: copies YADE's bodies and contacts into the arrays of rcr::Step.
#pragma once

#include "kernel/parallel/thread_team.hpp"
#include "kernel/step/step.hpp"
#include "dem/contacts/CdPhys.hpp"
#include "dem/transfer/PairRules.hpp"
#include "dem/validation/validation.hpp"
#include "dem/contacts/RcrGeom.hpp"

namespace yade {

/// YADE's objects of a step. Pointers hold until YADE's bodies or interactions change; ArraySteps
/// stops before that.
struct SceneHandles {
	/// A contact in YADE; StepContact::source is its number.
	struct Contact {
		RcrGeom*     geom        = nullptr;
		CdPhys*      phys        = nullptr;
		Interaction* interaction = nullptr;
		Body::id_t   id1 = 0, id2 = 0;
		int          points = 0;
	};

	std::vector<State*>       state; // per body; null: no body
	std::vector<const Bound*> bound; // per body
	std::vector<char>         isUnlisted; // per body: the collider may miss contacts of this step
	PairRules                 pairRules; // of the last step
	// in the order of YADE's container; 0 points: not a contact of this law
	std::vector<Contact>      found;
	std::vector<Contact>      sorted; // by body 1, then body 2
	Real                      z = 0; // height of the plane
};

/// Sets bodies, contacts, loads and start forces. Throws std::invalid_argument for unsupported
/// scenes; changes nothing in the scene.
void gather(Scene&, const validation::Engines&, rcr::ThreadTeam&, SceneHandles&, rcr::Step&);

/// Gathers some of the bodies again, with the forces on them.
void regatherBodies(Scene&, const validation::Engines&, rcr::ThreadTeam&,
        const std::vector<Body::id_t>&, SceneHandles&, rcr::Step&);

struct ContactLaw {
	double friction, restitution;
};
/// Friction and restitution of a new contact, by the Ip2 functor of the scene.
ContactLaw contactLaw(Scene&, const InteractionLoop&, Body::id_t id1, Body::id_t id2);

/// The collider and the functors of the scene allow a contact of the two bodies. Throws if bodies
/// that may meet have no Ig2 functor.
bool mayMeet(Scene&, const validation::Engines&, Body::id_t id1, Body::id_t id2);

} // namespace yade

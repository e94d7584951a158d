// From YADE's objects to a step's numbers: the first stage, and the only one that reads bodies, geometry and physics.
#pragma once

#include <core/Interaction.hpp>
#include <core/Scene.hpp>
#include "../kernel/parallel/thread_team.hpp"
#include "../kernel/step/step.hpp"
#include "CdPhys.hpp"
#include "Gate.hpp"
#include "RcrGeom.hpp"

namespace yade {

/// YADE's objects behind the numbers of a step. Bodies and interactions come and go: valid within one step only.
struct StepSources {
	/// A contact as YADE has it; StepContact::source counts these.
	struct Contact {
		RcrGeom*     geom        = nullptr;
		CdPhys*      phys        = nullptr;
		Interaction* interaction = nullptr;
		Body::id_t   id1 = 0, id2 = 0;
		int          points = 0;
	};

	std::vector<State*>       state; // a body; null where there is none
	std::vector<const Bound*> bound; // a body
	std::vector<Contact>      found; // in the order of YADE's container; without points where it is none of ours
	std::vector<Contact>      sorted; // by body 1, then body 2
	Real                      z = 0; // of the plane
};

/// Bodies, contacts, loads and the forces to start from. Throws std::invalid_argument for what is not served; changes nothing.
void gather(Scene&, const gate::Engines&, rcr::ThreadTeam&, StepSources&, rcr::Step&);

/// Some of the bodies once more, with the forces on them.
void gatherAgain(Scene&, const gate::Engines&, rcr::ThreadTeam&, const std::vector<Body::id_t>&, StepSources&, rcr::Step&);

struct ContactLaw {
	double friction, restitution;
};
/// Of a contact of two bodies that is new, as the scene's Ip2 functor gives it.
ContactLaw contactLaw(Scene&, const InteractionLoop&, Body::id_t id1, Body::id_t id2);

/// Whether two bodies that are not in contact may come into one.
bool mayMeet(Scene&, const gate::Engines&, Body::id_t id1, Body::id_t id2);

} // namespace yade

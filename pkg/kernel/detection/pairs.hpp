// Neighbouring pairs with the data that their contacts carry from step to step.
//
// Steps in arrays use these data while the interactions of the simulation are out of date.
#pragma once

#include "detection/neighbors.hpp"

namespace rcr {

struct Pair {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t pointCount       = 0;     // contact points; 0: no contact
	std::int32_t handleIndex      = -1;    // index in SceneHandles::sorted; −1: none
	bool         isNew            = false; // found by the last detection
	long         formedAt = -1; // iteration of its first step; −1: stored in the simulation
	ContactLaw   law;
	double       along[2] {}; // positionAlong of each point [m]
	LocalVector  force[2];    // of each point [N]
	double       rollingMoment = 0; // of a contact of one point [N m]
};

struct Pairs {
	std::vector<Pair>     all;      // sorted by body1, then body2
	std::vector<Manifold> manifold; // per pair, if it touches

	/// Replaces the pairs by those of the list; known pairs keep their data. `keepContacts`:
	/// contacts that the list lacks remain.
	void assign(const Neighbors::List&, bool keepContacts = false);

	/// Detects the contact points of every pair at the poses of the step and carries their forces
	/// forward. `keepContacts`: contacts beyond the present reach remain.
	void detect(const Step&, ThreadTeam&, bool keepContacts);

	void addFoundContacts(const Step&, long iteration); // those of Step::added
	void numberContacts(Step&) const;                  // sets StepContact::handleIndex
	void fillStep(Step&, ThreadTeam&) const;           // with contacts and their first forces
	void storeForces(const Step&, ThreadTeam&);        // of a solved step
};

} // namespace rcr

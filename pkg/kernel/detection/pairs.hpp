// Neighbouring pairs with the data that their contacts carry from step to step.
//
// Steps in arrays use these data while the interactions of the simulation are out of date.
#pragma once

#include "detection/late_contacts.hpp"

namespace rcr {

struct Pair {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t pointCount       = 0;     // contact points; 0: no contact
	std::int32_t handleIndex      = -1;    // index in SceneHandles::sorted; −1: none
	bool         isNew            = false; // found by the last detection
	long         formedAt = -1; // iteration of its first step; −1: stored in the simulation
	Vec2         shift;         // from body 2 to its image that meets body 1 [m]
	ContactLaw   law;
	double       along[2] {}; // positionAlong of each point [m]
	LocalVector  force[2];    // of each point [N]
	double       rollingMoment = 0; // of a contact of one point [N m]
};

struct Pairs {
	std::vector<Pair>     all;      // sorted by body1, then body2
	std::vector<Manifold> manifold; // per pair, if it touches

	/// Detects the contact points of all pairs that may meet, at the poses of the step, and carries
	/// their forces forward. New contacts get their law and the number of the step. `keepContacts`:
	/// contacts beyond the present reach remain.
	void detect(Search, const Step&, const NewContacts&, long iteration, bool keepContacts = false);

	/// Stores the forces of a solved step, and the contacts that it added.
	void store(Step&, ThreadTeam&, long iteration);

	void fillStep(Step&, ThreadTeam&) const; // with contacts and their first forces

	bool listed = false; // `all` holds the neighbours; else its pairs come from the simulation

private:
	void numberContacts(Step&) const; // sets StepContact::handleIndex
	void assign(const Neighbors::List&, bool keepContacts = false);
	void detectPoints(const Step&, ThreadTeam&, bool keepContacts);
	void addFoundContacts(const Step&, long iteration);
};

} // namespace rcr

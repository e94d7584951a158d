// Neighbouring pairs with the data that their contacts carry from step to step.
//
// Steps in arrays use these data while the interactions of the simulation are out of date.
#pragma once

#include "detection/neighbors.hpp"

namespace rcr {

struct Pair {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t points   = 0;     // contact points; 0: no contact
	std::int32_t interactionIndex = -1; // number of the contact in the simulation; −1: none
	bool         isNew    = false; // its friction and restitution are not set yet
	// iteration in which the contact formed; −1: it is stored in the simulation
	long         formedAt = -1;
	double       friction = 0, restitution = 0;
	// positionAlong of each point [m]
	double       along[2] {};
	Impulse      force[2];         // of each point [N]
};

struct Pairs {
	std::vector<Pair>     all;      // sorted by body1, then body2
	std::vector<Manifold> manifold; // per pair, if it touches

	/// Replaces the pairs by those of the list; known pairs keep their data. `keepContacts`:
	/// contacts that the list lacks remain.
	void assign(const Neighbors::List&, bool keepContacts = false);

	/// Detects the contact points of every pair at the poses of the step and carries their forces
	/// forward. `keepContacts`: contacts beyond the present reach remain.
	void detect(const Step&, ThreadTeam&, bool keepContacts = false);

	/// Adds the contacts that the step has added (Step::added).
	void addDetected(const Step&, long iteration);

	/// Sets StepContact::listIndex of the contacts to the numbers of their pairs.
	void numberContacts(Step&) const;

	/// Sets the contacts of the step and the forces from which they start.
	void writeContacts(Step&, ThreadTeam&) const;

	/// Stores the forces of a solved step.
	void keepForces(const Step&, ThreadTeam&);
};

} // namespace rcr

// Neighbouring pairs with the data that their contacts carry from step to step.
//
// With them, steps follow each other without access to the simulation.
#pragma once

#include <vector>

#include "detection/neighbours.hpp"

namespace rcr {

struct Pair {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t points   = 0;     // contact points; 0: no contact
	std::int32_t source   = -1;    // number of the contact in the simulation; −1: none
	bool         fresh    = false; // new contact, whose friction and restitution the caller sets
	// iteration in which the contact formed; −1: stored in the simulation
	long         since    = -1;
	double       friction = 0, restitution = 0;
	// position of each point along the body by whose axis points are sorted [m]
	double       along[2] {};
	Impulse      force[2];         // of each point [N]
};

struct Pairs {
	std::vector<Pair>     all;      // sorted by body1, then body2
	std::vector<Manifold> manifold; // per pair, if it touches

	/// Replaces the pairs by those of the list; known pairs keep their data. `again`: contacts
	/// remain that the list does not hold any more.
	void assign(const Neighbours::List&, bool again = false);

	/// Detects the contact points of every pair at the poses of the step and carries their forces
	/// forward. `again`: engines have changed velocities; contacts beyond the new reach remain.
	void detect(const Step&, ThreadTeam&, bool again = false);

	/// Adds the contacts that the step found after its detection.
	void addFound(const Step&, long iteration);

	/// Sets StepContact::source of the contacts to the numbers of their pairs.
	void numberContacts(Step&) const;

	/// Sets the contacts of the step and the forces from which they start.
	void writeContacts(Step&, ThreadTeam&) const;

	/// Stores the forces of a solved step.
	void keepForces(const Step&, ThreadTeam&);
};

} // namespace rcr

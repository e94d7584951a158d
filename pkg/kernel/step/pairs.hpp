// Pairs of neighbours with what their contacts carry from step to step: all that the next step needs of
// the last one, so that it can be taken without a look at the simulation.
#pragma once

#include <vector>

#include "step/neighbours.hpp"

namespace rcr {

struct Pair {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t points   = 0;     // 0: they do not touch
	std::int32_t source   = -1;    // number under which the simulation knows the contact; −1: it does not
	bool         fresh    = false; // a contact since the last detection, whose friction and restitution are to be set
	long         since    = -1;    // iteration since which they touch; −1: the simulation knows
	double       friction = 0, restitution = 0;
	double       along[2] {};      // place of each point along the body by whose axis the points are sorted [m]
	Impulse      force[2];         // of each point [N]
};

struct Pairs {
	std::vector<Pair>     all;      // sorted by body1, then body2
	std::vector<Manifold> manifold; // of each, where it touches

	/// Makes the pairs those of this list; what was carried from step to step stays.
	void become(const Neighbours::List&);

	/// Finds the contact points of every pair at the poses of the step. Forces go to the points that carry on.
	void detect(const Step&, ThreadTeam&);

	/// Takes in the contacts that the step has found on its way.
	void takeIn(const Step&, long iteration);

	/// Lets the contacts of the step know their pairs: StepContact::source.
	void number(Step&) const;

	/// Contacts of the step, the points of which start from the forces of the pairs; StepContact::source is the number of the pair.
	void contacts(Step&, ThreadTeam&) const;

	/// Takes over the forces of a solved step.
	void keepForces(const Step&, ThreadTeam&);
};

/// Forces of the points that a contact had go to the points that it has: two keep their order; where one becomes two or two one, the
/// nearest takes over, since the other has just opened or closed. `along` is the place of a point along its body, `force` a pair of forces.
template <class Along, class Force>
inline void carryForward(int before, const Along& alongBefore, int now, const Along& alongNow, Force& force1, Force& force2, const Force& none)
{
	if (before == 1 && now == 2) {
		const bool second = std::abs(alongNow[1] - alongBefore[0]) < std::abs(alongNow[0] - alongBefore[0]);
		force2            = second ? force1 : none;
		if (second) force1 = none;
	} else if (before == 2 && now == 1) {
		if (std::abs(alongBefore[1] - alongNow[0]) < std::abs(alongBefore[0] - alongNow[0])) force1 = force2;
		force2 = none;
	}
}

} // namespace rcr

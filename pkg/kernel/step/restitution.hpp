// b_n of a point at the beginning of a step, and restitution that would give energy.
//
//   b_n = g/dt    where the gap is open: it may close within the step but not more
//   b_n = e u_n⁻  where a bounce falls into the step: the velocity of approach is returned by the factor e
//   b_n = 0       in a lasting contact
//
// Newton's rule returns the normal velocity whatever else happens meanwhile, and gives energy in two cases. Of one point, where
// friction reverses the slip: there the restitution is lowered to what keeps it (passiveRestitutionFactor in problem/coulomb.hpp). Of a
// collision, where a blow throws a body against one that it was leaving: that contact stops it, the first returns its velocity in
// spite of it, and a light body between two heavy ones works as a lever. The collision is all bodies that impulses join in the step;
// its energy grows by
//
//   ΔE = ½ Σ p · (u + u⁻)
//
// over its points. Without restitution it falls, by some ½ Σ p_n |u_n⁻| / (1 + e) = L over the points that bounce. The restitution of
// all of them is lowered by the share L / (L + 3/2 ΔE), until none is gained: L is larger than what a lever takes.
// Two bounces of a body that fall into one step may have no solution: the first returns it faster than the gap behind it is wide.
// Its restitution is lowered to what there is room for.
// Source: Newton's rule after Moreau 1999; Kane and Levinson 1985 (its energy).
#pragma once

#include "step/step.hpp"

namespace rcr {

/// b_n of a point with this gap; approach() is its normal velocity at the beginning, asked for only where e > 0.
template <class Approach> double lawBias(double gap, double restitution, double dt, Approach approach)
{
	if (restitution > 0) {
		const double u = approach();
		if (u < 0 && gap + dt * u < 0) return restitution * u;
	}
	return gap > 0 ? gap / dt : 0;
}

/// Looks at a contact of the solved step, and lowers its biases where they have given energy; true if one has changed.
bool restrainBounce(Step&, const StepContact&);

/// Looks at a step without a solution: bounces that were not reached are lowered to what was, or, where `plastic` says so, given up;
/// true if there were any.
bool lowerBounces(Step&, bool plastic);

/// The same of each collision as a whole: its bodies keep their relative velocity by less, or, where `plastic` says so, not at all.
bool restrainCollisions(Step&, bool plastic);

} // namespace rcr

// b_n of a point at the beginning of a step, and restitution that would give energy.
//
//   b_n = g/dt    where the gap is open: it may close within the step but not more
//   b_n = e u_n⁻  where a bounce falls into the step: the velocity of approach is returned by the factor e
//   b_n = 0       in a lasting contact
//
// Newton's rule returns the normal velocity whatever friction does meanwhile, and where the slip reverses, it gives energy. There
// the restitution is lowered to what keeps it (passiveShare in problem/coulomb.hpp).
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

} // namespace rcr

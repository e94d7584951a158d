// What the contacts of a step take from the kinetic energy, from the mean of the velocities before and after it:
//
//   T⁺ − T⁻ = Σ p · ½ (u⁻ + u⁺) − Σ p · d + external work      over the points; exact for any impulses
//
// The tangential part is friction's, the normal one that of impacts. Bodies of prescribed motion take part of the work in their
// blocked degrees of freedom, or give it. Source: Moreau 1999; Kane and Levinson 1985.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Energies of one step [J], per unit depth.
struct StepEnergy {
	double friction = 0, impact = 0; // dissipated
	double driven   = 0;             // that contacts have given to prescribed motion; negative where it drives
	double lifted   = 0;             // potential energy that the position correction has given, in the field `gravity`
};

/// Of the solved step, whose displacements are made. `load` is the sum of the impulses on each body.
StepEnergy stepEnergy(const Step&, const std::vector<Twist>& load, Vec2 gravity);

} // namespace rcr

// Energy that the contacts of a step dissipate or transfer. It follows from the mean of the
// velocities before and after the step, summed over the points, with rolling resistance as friction
// and adhesion as impact:
//
//   T⁺ − T⁻ = Σ p · ½ (u⁻ + u⁺) − Σ p · d + external work      exact for any impulses
//
// d is the velocity of the periodic image of body 2 relative to the body. The tangential part is
// friction unless restitution reverses the slip; the rest is impact. Prescribed degrees of freedom
// take or supply a part of this work. Source: Moreau 1999; Kane and Levinson 1985.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Energies of one step [J], per unit depth.
struct StepEnergy {
	double friction = 0, impact = 0; // dissipated
	// work of contacts on prescribed motion; negative if that motion drives the grains
	double driven   = 0;
	double lifted   = 0;             // potential energy added by the position correction
};

/// Energies of a solved step with its displacements. `impulses`: sum of the contact impulses
/// on each body; `gravity` [m/s²].
StepEnergy stepEnergy(const Step&, const std::vector<PlanarVector>& impulses, Vec2 gravity);

} // namespace rcr

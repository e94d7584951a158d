// Whether the contact laws of a step ask for more than its bodies can do.
//
// Admissible velocities v open every point faster than friction can hold it: u_n + b_n ≥ µ |u_t|. Where some exist (with > instead
// of ≥), the step has a solution. Every d in the cones K = { |d_t| ≤ µ d_n } has d · (u + b_n n) ≥ 0 for all of them, and with
// u = u_free + J (v − v_free) this bounds how far they are from the free velocities:
//
//   ‖v − v_free‖_M ≥ −d · (u_free + b_n n) / ‖M^(−1/2) Jᵀ d‖
//
// Impulses d that grow without moving anything (Jᵀ d → 0) while they are pressed together make the bound infinite: a certificate that no
// velocities do, as for a wedge between driven walls. Solvers of a step without a solution find such impulses by themselves.
// Source: Acary, Cadoux, Lemaréchal and Malick 2011 (criterion); its dual by Farkas' lemma.
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

/// The bound of the impulses `direction`, once projected onto their cones, in units of √(Σ m) max |u_free|: the RMS change of speed that
/// admissible velocities need, over the greatest relative velocity without contacts [-]. Masses and velocities are those where the
/// direction acts. Large: the step has no solution worth reaching. Infinity: none at all. 0 or less: the direction proves nothing.
double requiredSpeed(const ContactProblem&, const std::vector<Impulse>& direction);

} // namespace rcr

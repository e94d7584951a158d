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
//
// The scale of such a change is V = √(Σ m) (max |u_free| + Σ max(0, −b_n)), of the bodies and points where d acts: overlaps that are to
// open push a row of bodies apart at the sum of their speeds. Measured on beds that rest, flow or are driven, of 20 to 2000 grains: solved
// steps need at most 1.0 V by their impulses and take at most 0.2 V² of energy; sweeps on from where a solver missed its tolerance prove at
// most 0.2 V. In steps without a solution all of them grow beyond any bound.
// Source: Acary, Cadoux, Lemaréchal and Malick 2011 (criterion); its dual by Farkas' lemma.
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

/// The bound above of the impulses `direction`, once projected onto their cones, in units of V [-]. Infinite: no velocities are admissible.
/// 0: the direction proves nothing.
double requiredSpeed(const ContactProblem&, const std::vector<Impulse>& direction);

/// −Σ p · (u + b_n n): the energy that contacts take in the step [J/m]; friction's in a solution, and that of points that close [J/m].
double energyTaken(const ContactProblem&);

/// Whether ½ pᵀWp + p · (u_free + b_n n), which frictionless impulses minimise and which is 0 without any, is positive: a step that missed its
/// tolerance would give energy, as far-off starts of solvers do.
bool worseThanNone(const ContactProblem&);

/// Whether the impulses take so much energy that, by 2 √energy ≤ the bound of the impulses themselves, velocities would have to change by
/// more than three times V. True in a step without a solution whose impulses have grown so far that its errors seem small beside them.
bool takesTooMuch(const ContactProblem&);
/// The same with all masses and the RMS |u_free| of all points, at the cost of a pass over the bodies: what is to be asked first.
bool mayTakeTooMuch(const ContactProblem&, double energy, double freeSpeed);

constexpr int    probeSweeps = 100;  // over which impulses grow in a step without a solution …
constexpr double leastGrowth = 0.03; // … by more than this share; those that converge change by less

/// Whether the impulses still grow, by `leastGrowth` since `before` at least, and by what proves that velocities would have to change by more than three times V.
bool growsWithoutBound(const ContactProblem&, const std::vector<Impulse>& before);

} // namespace rcr

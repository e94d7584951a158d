// Tests whether a step has no solution: the contact laws require more than the bodies can do.
//
// Velocities v are admissible if every point opens faster than friction can hold:
// u_n + b_n ≥ µ |u_t|. The step has a solution if strictly admissible velocities exist.
// For every d in the cones K = { |d_t| ≤ µ d_n }, admissible velocities satisfy
// d · (u + b_n n) ≥ 0. With u = u_free + J (v − v_free), this bounds their distance to v_free:
//
//   ‖v − v_free‖_M ≥ −d · (u_free + b_n n) / ‖M^(−1/2) Jᵀ d‖
//
// An infinite bound certifies that no admissible velocities exist: impulses d grow, move nothing
// (Jᵀ d → 0), and are pressed together. An example is a wedge between driven walls. Solvers diverge
// along such directions in a step without a solution.
//
// The scale of a velocity change is V_s = √(Σ m) A (max(µ₁ |u_free|, |Δv_free|) + Σ max(0, −b_n))
// over the bodies and points where d acts, with µ₁ = max(1, µ). Δv_free is the range of the free
// velocities of these bodies: small approach velocities of the pairs in a row add up to it. So do
// the biases: overlaps push a row apart at the sum of their speeds. A is the product of the ratios
// of the longest to the shortest lever of hinged bodies. Σ m includes the inertia of a cell that
// stretches, divided by the square of its length. Measurements cover 20 to 2000 grains at
// rest, in flow, and driven. Solved steps need at most 1.0 V_s and dissipate at most 0.2 V_s². In
// feasible steps that miss the tolerance, growing impulses imply at most 0.2 V_s. In steps without
// a solution, all three measures grow without bound. Source: Acary, Cadoux, Lemaréchal and Malick
// 2011 (criterion); Farkas' lemma (its dual).
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

/// −Σ p · (u + b_n n): energy that contacts dissipate in the step [J/m]. It includes the work of
/// friction, and of points that still close.
double dissipatedEnergy(const ContactProblem&);

/// Returns true if the bound for d = p exceeds 3 V_s. This detects steps without a solution whose
/// impulses are so large that their relative error is small.
bool exceedsChangeBound(const ContactProblem&);

/// Returns true if 2 √E > 3 V_s, with the dissipated energy E. With N² = pᵀWp, the bound for d = p
/// is (E + N²)/N ≥ 2 √E, so this test is the weaker one. It decides whether contacts yield.
bool exceedsEnergyBound(const ContactProblem&);

/// The same test for an energy and the velocity scale V_s of its bodies.
bool exceedsEnergyBound(double energy, double velocityScale);

/// Returns true if a prescribed motion closes a contact and also blocks its normal direction.
/// No impulse can open such a contact.
bool closesBlocked(const ContactProblem&, const ContactPoint&, double roundingVelocity);

/// A of the points with an impulse d_n > least. For all points: least = −1 and no d.
double leverAmplification(
        const ContactProblem&, const std::vector<LocalVector>& d = {}, double least = -1);

constexpr double maxChange  = 3;    // velocity change over V_s that no solution requires
constexpr double noiseShare = 1e-3; // impulses below this share of the largest one are noise

constexpr int    probeSweeps     = 100;  // sweeps over which the growth of impulses is measured
constexpr double divergentGrowth = 0.03; // least relative growth of diverging impulses

/// The bound for the growth of the impulses since `before`, over V_s [-].
double boundOfGrowth(const ContactProblem&, const std::vector<LocalVector>& before);

/// Returns true if the impulses grew by at least divergentGrowth since `before`. The growth must
/// also require a velocity change of more than 3 V_s.
bool isDivergent(const ContactProblem&, const std::vector<LocalVector>& before);

} // namespace rcr

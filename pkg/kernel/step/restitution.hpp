// Lowers restitution that would add energy.
//
// Newton's rule adds energy in two cases. Friction may reverse the slip at a point. Its
// restitution is then lowered to the value that keeps the energy (passiveRestitutionFactor in
// problem/coulomb.hpp). The points of one pair of bodies count together, because the split of
// their friction is not determined. In a collision of several bodies, a light body between two
// heavy ones acts as a lever. A collision is a set of bodies joined by impulses of the step. Its
// energy grows by
//
//   ΔE = ½ Σ p · (u + u⁻)
//
// over its points. Without restitution it would lose about the energy L = ½ Σ p_n |u_n⁻| / (1 + e)
// over the points with restitution. All their biases are multiplied by L / (L + 3/2 ΔE) until
// ΔE ≤ 0. A step in which one body collides twice may have no solution. lowerRestitutionOfYielded
// then limits the restitution of a point to its solved normal velocity. In a collision, the
// bias of a large displacement counts like restitution. Source: Newton's rule
// after Moreau 1999; Kane and Levinson 1985 (its energy).
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Lowers the restitution of two bodies if their contact points together add energy in the solved
/// step. Returns true if a bias changed.
bool lowerPairRestitution(Step&);

/// Limits the restitution of yielded points to their solved normal velocity; `plastic`: removes it.
/// Skips points of full restitution that bear no more than in an impact of two free bodies: their
/// restitution is not the reason. Returns true if a bias changed: contacts may then be rigid again.
bool lowerRestitutionOfYielded(Step&, bool plastic);

/// Removes all restitution and the corrections that push bodies apart, so no step adds energy.
void removeNegativeBiases(Step&);

/// Lowers the restitution of collisions that add energy; `plastic`: to 0. `tolerance`: of the
/// solver [-]. Returns true if a bias changed.
bool lowerCollisionRestitution(Step&, bool plastic, double tolerance);

} // namespace rcr

// Removes overlaps that curved paths leave at the end of a step.
//
// The velocities of a step satisfy 0 ≤ u_n + b_n ⟂ p_n ≥ 0 at the tangent planes of its beginning
// (contact_problem.hpp). A rod that is spun up in the step rolls over the body that it touches. Its
// path is curved, so it ends inside that body, by λ²/2ρ (large_displacements.hpp). A velocity that
// avoids this overlap would act like an elastic impact. Bodies are displaced by δ instead, in
// addition to the position correction, and keep their velocities. The gaps g_end at the displaced
// positions satisfy
//
//   g_end ≥ α min(g_start, 0) − slop        at all contacts of bodies with δ ≠ 0
//
// α = 1/2 for large displacements, else 1. Contacts that violate this with overlaps above 10 slops
// start displacements. Nonlinear Gauss–Seidel solves it in the metric of the masses, in at most 200
// sweeps. A contact counts as solved within one slop. Contacts that displaced bodies reach join.
// Bodies whose contacts yield get no δ. Only steps with a large displacement are separated. Source:
// position solver of Box2D (Catto 2011); Cline and Pai 2003 (post-stabilization).
#pragma once

#include "detection/late_contacts.hpp"

namespace rcr {

/// Adds δ to step.displacement if `displace` is true. Returns the deepest overlap at the end that
/// exceeds 10 slops and the bound above, over R₁ + R₂ [-]. Overlaps of two prescribed bodies do not
/// count. Sets step.intruding and returns 1 if bodies have intruded on their paths. If one has even
/// passed through the other, there are no displacements.
double separate(Step&, bool displace, const Search&);

} // namespace rcr

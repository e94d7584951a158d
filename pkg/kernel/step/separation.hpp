// Removes the overlaps at the end of a step that curved paths leave.
//
// The velocities of a step satisfy the law at the tangent planes of its beginning. A rod that is
// spun up in the step rolls over the body that it touches and then ends inside it, by the curvature
// s²/2ρ of its path. A velocity that avoids this would make the contact an elastic bounce. Bodies
// are instead displaced, without a change of velocity, until no contact overlaps more than at the
// beginning of the step:
//
//   g(x + dt v + δ) ≥ min(g, 0) − slop        for all contacts of bodies that are displaced
//
// This is solved by nonlinear Gauss–Seidel, in the metric of the masses, with gaps detected at the
// displaced positions. Contacts of displaced bodies join the system. Source: position solver of
// Box2D (Catto 2011); Cline and Pai 2003 (post-stabilization).
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Adds the displacements of bodies to step.displacement, if `displace` is true. Returns the deepest overlap at the end of
/// the step over R₁ + R₂ [-], of contacts with a large displacement and of displaced bodies; 1 and
/// no displacements if a body has passed through another one.
double separate(Step&, bool displace);

} // namespace rcr

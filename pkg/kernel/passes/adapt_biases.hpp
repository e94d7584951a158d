// Corrects the biases of contacts after a solve.
//
// After a large displacement, the gap differs from the gap in the bias, and restitution may add
// energy. The biases are then adapted and the step is solved again. If the adapted problem has no
// solution, contacts yield.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Returns true if rest satisfies the contact laws: no contact point is driven and no bias is
/// negative. The step then has a solution.
bool restIsAdmissible(const Step&, double driveSpeed);

/// Adapts the biases. Returns true if one changed.
///   allowRelease        contacts may be released
///   nextIsLast          only one pass follows: it keeps biases of displacements and removes
///                       restitution that adds energy
///   tolerance           of the solver [-]
///   largeDisplacements  out: a contact has a large displacement
bool adaptBiases(Step&, bool allowRelease, bool nextIsLast, double tolerance,
        bool& largeDisplacements, ThreadTeam&);

} // namespace rcr

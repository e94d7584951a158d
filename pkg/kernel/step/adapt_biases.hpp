// Corrects the biases of contacts after a solve.
//
// After a large displacement, the gap differs from the one in the bias, and bounces may add energy.
// The biases are then adapted and the step is solved again. The adapted problem may have no
// solution. If no body is driven and all original biases are ≥ 0, these are restored: u_n = 0 is
// then possible, so the step has a solution.
#pragma once

#include "parallel/thread_team.hpp"
#include "step/drive.hpp"

namespace rcr {

/// Rest satisfies the contact laws: no body is driven and no contact must open. The step then has a
/// solution.
bool restIsSolution(const Step&, const DrivenMotion&);

/// Adapts the biases; returns true if one changed. `allowRelease`: contacts may be released;
/// `last`: bounces that add energy become plastic; `tolerance`: of the solver; `far`: set to true
/// if a contact has a large displacement. The last pass adds no pushes.
bool adaptBiases(Step&, bool allowRelease, bool last, double tolerance, bool& far, ThreadTeam&);

/// Restores biases and clears `before`; returns false if `before` is empty.
bool restoreBiases(Step&, std::vector<double>& before);

} // namespace rcr

// What a solved step shows to be wrong with its own biases.
//
// Bodies that turn or pass far within a step end elsewhere than its contacts have them, and bounces may give energy: their biases are
// adapted, and the step is solved once more. What passes ask for may have no solution. Where nothing drives the bodies it is taken back:
// rest breaks no law there.
#pragma once

#include "parallel/thread_team.hpp"
#include "step/drive.hpp"

namespace rcr {

/// Where nothing is driven and no contact has to open, every step has a solution.
bool restIsAllowed(const Step&, const Drive&);

/// True if a bias has changed. `letGo`: contacts may be found not to be needed; `last`: bounces are lowered for good. `overlap` is the deepest, over R₁ + R₂.
bool adaptBiases(Step&, bool letGo, bool last, double& overlap, ThreadTeam&);

/// To biases as they were before; false where there are none. They are used up.
bool goBack(Step&, std::vector<double>& before);

} // namespace rcr

// Saves the contact problem of a step whose solution is not finite.
#pragma once

#include <string>

#include "kernel/step/step.hpp"

namespace yade {

/// Saves the problem to a file and returns a sentence that names it. Defined beside the Python
/// module, whose writer it calls.
std::string saveFailedProblem();

/// Message about a body whose solved velocity is not finite. Saves the problem.
std::string failureMessage(const rcr::Step&, int id, long number);

} // namespace yade

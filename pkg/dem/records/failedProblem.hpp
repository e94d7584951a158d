// Saves the contact problem of a step whose solution is not finite.
#pragma once

#include <string>

#include "kernel/step/step.hpp"

namespace yade {

/// Saves the problem to a file and returns a message that names the file and a body whose solved
/// velocity is not finite. Defined beside the Python module, whose writer it calls.
std::string failureMessage(const rcr::Step&, int id, long number);

} // namespace yade

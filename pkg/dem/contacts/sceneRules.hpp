// Rules that functors check in YADE's parallel loop. They concern the whole scene with all its
// engines and functors, so dem/validation defines them.
#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade::validation {

/// Returns true if the interaction may become a contact. Its bodies must have a FrictMat, YADE must
/// allow the pair, and the scene must be valid. ContactDynamics throws the error of the scene later
/// in this step. Errors of scenes without ContactDynamics are deferred to Python.
bool acceptContact(const Interaction&, const Scene&);

/// Message if rigid contacts have no active ContactDynamics; else empty.
std::string missingSolver(const Scene&);

} // namespace yade::validation

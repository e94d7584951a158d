// Adds contacts of a step that the InteractionLoop has not made.
#pragma once

#include "dem/transfer/gather.hpp"

namespace yade {

/// Detects contacts of bodies that may lack contacts and adds them to the step. So the contacts do
/// not depend on the last run of the collider. After a change of PairExclusions, restarts the
/// collider and validates the scene. `solver`: the engine that solves the step.
void addUnlistedContacts(Scene&, const validation::Engines&, const Engine& solver, SceneHandles&,
        rcr::Step&);

/// Finds undetected contacts of the solved step (kernel/detection/undetected_contacts.hpp). Returns
/// false if none closes.
bool findUndetectedContacts(Scene&, const validation::Engines&, rcr::Step&);

/// Finds undetected contacts and adds them to the problem. Returns false if none closes.
bool addUndetectedContacts(Scene&, const validation::Engines&, rcr::Step&);

} // namespace yade

// Contacts of a step that the InteractionLoop has not listed.
#pragma once

#include "dem/transfer/gather.hpp"

namespace yade {

/// Completes the contacts within reach, so that they do not depend on when the collider ran.
/// After a change of PairRules, restarts the collider and validates the scene. `solver` is the
/// engine that solves the step.
void addUnlistedContacts(Scene&, const validation::Engines&, const Engine& solver, SceneHandles&,
        rcr::Step&);

/// Finds contacts that form within the step (kernel/detection/missed_contacts.hpp). Returns false
/// if there are none.
bool findMissedContacts(Scene&, const validation::Engines&, rcr::Step&);

/// Finds them and adds them to the problem.
bool addMissedContacts(Scene&, const validation::Engines&, rcr::Step&);

} // namespace yade

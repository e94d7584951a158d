// Adds contacts that the InteractionLoop has not made: unlisted ones before the solve, late ones
// after it.
#pragma once

#include "dem/transfer/gather.hpp"
#include "kernel/detection/late_contacts.hpp"

namespace yade {

/// Coefficients of a new contact by the Ip2 functor of the scene.
rcr::ContactLaw newContactLaw(Scene&, const InteractionLoop&, Body::id_t id1, Body::id_t id2);

/// Returns a filter: true for two bodies whose contact the scene's collider, functors and materials
/// allow. The filter throws if no Ig2 functor handles bodies that could overlap.
rcr::ContactFilter contactFilter(Scene&, const validation::Engines&);

/// Detects contacts that YADE may not have listed, and adds them to the step. So the contacts do
/// not depend on the last run of the collider. After a change of PairExclusions, restarts the
/// collider and validates the scene. `solver`: the engine that solves the step.
void addUnlistedContacts(Scene&, const validation::Engines&, const Engine& solver, SceneHandles&,
        rcr::Step&);

/// If the solved step has a late contact (kernel/detection/late_contacts.hpp), adds all found
/// contacts to it and returns true.
bool addLateContacts(Scene&, const validation::Engines&, rcr::Step&);

} // namespace yade

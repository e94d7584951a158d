// Adds contacts that the InteractionLoop has not made: unlisted ones before the solve, late ones
// after it.
#pragma once

#include "dem/transfer/gather.hpp"
#include "kernel/passes/solve_step.hpp"

namespace yade {

/// New contacts of a step, with a filter that allows those of the scene's collider, functors and
/// materials. The filter throws if no Ig2 functor handles bodies that could overlap.
rcr::NewContacts newContacts(Scene&, const validation::Engines&);

/// Detects contacts that YADE may not have listed, and adds them to the step. So the contacts do
/// not depend on the last run of the collider. After a change of PairExclusions, restarts the
/// collider and validates the scene. `solver`: the engine that solves the step.
void addUnlistedContacts(Scene&, const validation::Engines&, const Engine& solver,
        rcr::ThreadTeam&, SceneHandles&, rcr::Neighbors&, rcr::Step&);

} // namespace yade

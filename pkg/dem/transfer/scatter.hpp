// Last stage of a step: writes its results to YADE's objects.
#pragma once

#include "dem/transfer/gather.hpp"

namespace yade {

/// Sum of the contact impulses on each body and of their moments about its centre [N s, N m s].
/// Impulses on clump members count for the clump.
std::vector<rcr::PlanarVector> contactImpulses(const rcr::Step&);

void setUnblockedVelocity(State&, const rcr::PlanarVector& velocity); // its unblocked components
void applyCorrection(State&, const rcr::PlanarVector& by);            // displaces a body

/// Writes contact forces, forces on bodies, added contacts, displacements, start velocities of
/// overdamped bodies, and the stretch of the cell. Requests a run of the collider if bodies leave
/// their boxes.
void scatter(Scene&, rcr::ThreadTeam&, const std::vector<rcr::PlanarVector>& impulses,
        SceneHandles&, rcr::Step&);

/// Sorts YADE's interactions by bodies if many are out of order. Loops over interactions then find
/// bodies in the cache.
void sortInteractions(Scene&, const SceneHandles&);

} // namespace yade

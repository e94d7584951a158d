// Last stage of a step: writes its results to YADE's objects.
#pragma once

#include "dem/transfer/gather.hpp"
#include "kernel/detection/pairs.hpp"

namespace yade {

/// Sum of the contact impulses on each body and of their moments about its centre [N s, N m s].
/// Impulses on clump members count for the clump.
std::vector<rcr::PlanarVector> contactImpulses(const rcr::Step&);

void setUnblockedVelocity(State&, const rcr::PlanarVector& velocity); // its unblocked components
void applyCorrection(State&, const rcr::PlanarVector& by);            // displaces a body

/// Writes the forces of both contact points and their sums; a missing point has the force 0.
void writeForce(CdPhys&, const rcr::LocalVector (&force)[2], const rcr::Vec2 (&normal)[2]);

/// Returns the interaction of a pair; creates it if there is none. `shift`: from body 2 to its
/// image.
Interaction& interactionOf(Scene&, const rcr::Pair&, rcr::Vec2 shift);

/// Writes the points of a pair to its interaction. Creates the CdPhys of a contact that formed in
/// arrays (`Pair::formedAt` ≥ 0). `at2`: pose of body 2 or of its image.
SceneHandles::Contact writeContact(Interaction&, const rcr::Pair&, const rcr::Manifold&,
        const rcr::Step&, const rcr::Pose& at2);

/// Writes contact forces, forces on bodies, added contacts, displacements, start velocities of
/// overdamped bodies, and the stretch of the cell. Requests a run of the collider if bodies leave
/// their boxes.
void scatter(Scene&, rcr::ThreadTeam&, const std::vector<rcr::PlanarVector>& impulses,
        SceneHandles&, rcr::Step&);

/// Sorts YADE's interactions by bodies if many are out of order. Loops over interactions then find
/// bodies in the cache.
void sortInteractions(Scene&, const SceneHandles&);

} // namespace yade

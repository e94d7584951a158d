// Last stage of a step: writes its results to YADE's objects.
#pragma once

#include "dem/transfer/gather.hpp"
#include "kernel/detection/pairs.hpp"

namespace yade {

/// Sum of the contact impulses on each body and of their moments about its centre [N s, N m s];
/// those on members act on the clump.
std::vector<rcr::Twist> contactImpulses(const rcr::Step&);

/// Sets the velocities of the free degrees of freedom to `rest`.
void resetVelocity(State&, const rcr::Twist& rest);

/// Displaces a body by the position correction.
void applyCorrection(State&, const rcr::Twist& by);

/// Returns the interaction of a pair and creates a missing one. `shift`: from body 2 to its image.
Interaction& interactionOf(Scene&, const rcr::Pair&, rcr::Vec2 shift);

/// Writes the points of a pair to its interaction. Creates the CdPhys of a contact that formed in
/// arrays (`Pair::since` ≥ 0). `at2`: pose of body 2 or of its image.
SceneHandles::Contact writeContact(Interaction&, const rcr::Pair&, const rcr::Manifold&,
        const rcr::Step&, const rcr::Pose& at2);

/// Writes contact forces, forces on bodies, missed contacts, displacements, start velocities of
/// overdamped bodies, and the stretch of the cell. Requests the collider if bodies need it.
void scatter(Scene&, rcr::ThreadTeam&, const std::vector<rcr::Twist>& impulses, SceneHandles&,
        rcr::Step&);

/// Sorts YADE's interactions by bodies if many are out of order, so that loops over them find
/// bodies in the cache.
void sortInteractions(Scene&, const SceneHandles&);

} // namespace yade

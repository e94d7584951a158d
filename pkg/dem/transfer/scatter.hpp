// Last stage of a step: writes its results to YADE's objects.
#pragma once

#include "dem/transfer/gather.hpp"

namespace yade {

/// Sum of the contact impulses on each body and of their moments about its centre [N s, N m s].
/// Impulses on clump members count for the clump.
std::vector<rcr::PlanarVector> contactImpulses(const rcr::Step&);

/// Sets the components of the velocity that YADE does not block.
void setUnblockedVelocity(State&, const rcr::PlanarVector& velocity);
void displace(State&, const rcr::PlanarVector& by);

/// Applies the motion of the cell in a solved step: its velocity gradient, and the strain of the
/// position correction.
void deformCell(Cell&, const rcr::PeriodicCell& now, rcr::Vec2 strain);

/// Writes contact forces, forces on bodies, added contacts, displacements, the velocities from which
/// overdamped bodies start the next step, and the stretch of the cell. Requests a run of the
/// collider if bodies leave their boxes. `impulses`: contactImpulses of the step.
void scatter(Scene&, rcr::ThreadTeam&, const std::vector<rcr::PlanarVector>& impulses,
        SceneHandles&, rcr::Step&);

} // namespace yade

// Mean stretch of overdamped bodies.
//
// An overdamped body starts a step with the velocity of a homogeneous flow, and only motion
// relative to the flow is resisted. If all bodies stretch otherwise, this drag adds up over the
// sample, to a stress of (L/d)² (t₀/dt)² times the strain error of a step. The mean stretch of a
// step is therefore added to the flow of the next step.
//
// The start impulses still contain the drag of the last flow, and sweeps would remove it slowly,
// contact by contact. It is therefore removed from the start impulses.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Mean stretch rate of the bodies in a solved step along each axis, relative to their start
/// velocities, about the origin: Σ m r (v − v_start) / Σ m r² [1/s].
Vec2 meanStretch(const Step&);

/// Removes the momentum m r e of all bodies from the start impulses, with the stretch rate e [1/s].
/// The impulse through a section at r falls by the momentum of the bodies beyond r.
void removeMomentum(Step&, Vec2 stretch);

} // namespace rcr

// Mean stretch of overdamped bodies.
//
// An overdamped body starts a step with the velocity of a homogeneous flow. A drag m Δv/dt resists
// its motion relative to the flow. Where the mean strain rate of the bodies differs from the flow,
// the drag adds up over the sample. The mean stretch of a step therefore enters the flow of the
// next step.
//
// The initial impulses of that step contain the drag of the earlier flow. removeDragImpulses
// subtracts it, because sweeps remove it slowly.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Mean stretch rate of the bodies in a solved step along each axis, about the origin: Σ m r (v −
/// v_start) / Σ m r² [1/s]. It is relative to the start velocities.
Vec2 meanStretchRate(const Step&);

/// Subtracts the drag of the earlier flow from the start impulses. A section at r transmits the
/// drag Σ m r ė of all bodies farther out, with the stretch rate ė [1/s]. An impulse changes by at
/// most half.
void removeDragImpulses(Step&, Vec2 stretchRate);

} // namespace rcr

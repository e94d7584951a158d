// The flow that bodies without inertia are at rest in, made that of the bodies themselves.
//
// A body starts an overdamped step with the velocity of a homogeneous flow, and what resists is its motion relative to that. Where all bodies
// together stretch otherwise, the drag adds up over the sample: by (L/d)² (t₀/dt)² times the stray strain of the step, of the stress. The
// stretch e that leaves none, Σ m r (v − e r) = 0 along each axis, is known once the step is solved; so the bodies start anew from there.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// Takes the stretch of the solved bodies about the origin into the velocities that they start from. True if it is more than a hundredth of the
/// flow's fastest rate: then the step is to be solved once more.
bool followStretch(Step&);

} // namespace rcr

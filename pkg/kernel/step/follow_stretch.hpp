// The flow that overdamped bodies start from, made that of the bodies themselves.
//
// A body starts an overdamped step with the velocity of a homogeneous flow, and what resists is its motion relative to that. Where all bodies
// together stretch otherwise, the drag adds up over the sample: by (L/d)² (t₀/dt)² times the stray strain of a step, of the stress. So what they
// stretched by in a step is taken into the flow of the next one.
//
// Sweeps alone would not find that there is no such drag any more: they carry news from contact to contact, and those between here and the walls
// bear it. It is taken out of the impulses that the next step starts from, which need to move the bodies beyond a place no longer.
#pragma once

#include "step/step.hpp"

namespace rcr {

/// What the bodies of a solved step have stretched by along each axis, about the origin and beyond what they started with: Σ m r (v − v_start) / Σ m r² [1/s].
Vec2 commonStretch(const Step&);

/// Takes the momentum m r e of all bodies, e a stretch [1/s], out of the impulses that a step starts from: of what passes through the sample at r, as
/// much as the bodies further away from the origin have.
void relieve(Step&, Vec2 stretch);

} // namespace rcr

// Overlaps taken back by displacements that never become velocities (split impulses).
//
// Overlaps are left by the tolerance of the solver, and by curvature within a step. The step is solved once more from its own
// impulses, now with u_n ≥ β |g|/dt where g overlaps, and the bodies move by dt (v_β − v) besides. The loads of the step are in
// both, so contacts stay closed that a displacement alone would open, for the law to close them in the next step with a blow.
//
// Only what an overlap has beyond the slop counts; without a slop, contacts at rest would open and close for ever. In a marginal
// packing one contact opens only if others move much further, and by the square of that they overlap anew: the farthest shift is
// bounded, all others in proportion. A cell that stretches is displaced with its bodies, as walls are.
// Source: Jourdan, Alart and Jean 1998.
#pragma once

#include "problem/solver.hpp"
#include "step/step.hpp"

namespace rcr {

/// Writes step.displacement and step.strain; leaves them empty and 0 where no overlap exceeds the slop. `share` is β. The workspace has solved the step last.
void correctPositions(Step&, double share, Workspace&);

/// Writes problem.recovery for a step whose contacts may yield: there an overlap is taken back by the same share, at finite forces, so that
/// grains which a drive wedges give way to each other as under springs.
void prepareRecovery(Step&, double share, ThreadTeam&);

} // namespace rcr

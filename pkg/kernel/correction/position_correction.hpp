// Removes overlaps by displacements that never become velocities (split impulses).
//
// The tolerance of the solver and the curvature of paths leave overlaps. Ten further sweeps
// start from the impulses of the step, with u_n ≥ β (|g| − slop)/dt at overlaps. The bodies are
// displaced by dt (v_β − v). Both velocities contain the loads of the step, so a displacement opens
// no loaded contact.
//
// Only the overlap beyond the slop counts. In a barely rigid packing, the opening of one contact
// would move other bodies far. The largest displacement of bodies and walls is therefore bounded,
// and all displacements are scaled by the same factor. A cell that stretches is strained with all
// its bodies; its strain is bounded, not the displacements by it. Source: Jourdan, Alart and Jean
// 1998.
#pragma once

#include "problem/solver.hpp"
#include "step/step.hpp"

namespace rcr {

/// Computes step.displacement and step.strain, once per step. They stay empty and 0 if no overlap
/// exceeds the slop, for β = 0, and in overdamped steps. The workspace must hold the solved step.
void computeCorrection(Step&, double beta, Workspace&);

/// Computes problem.recoveryBias: the biases with which yielding contacts remove the fraction β of
/// their overlaps beyond the slop.
void setRecoveryBias(Step&, double beta, ThreadTeam&);

} // namespace rcr

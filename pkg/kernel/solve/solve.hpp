// Solves the contact problem: the entry to all methods.
#pragma once

#include "problem/solver.hpp"

namespace rcr {

/// Runs a solver by name: nlgs, sor, nesterov, exact or auto. Lets contacts yield if required.
///
/// All islands are swept together. An island that has not met the criteria, or that may have no
/// solution, is then solved alone: with exact steps, with yielding contacts, or with sweeps from
/// zero impulses. So the verdict on an island does not depend on the others. If contacts may yield,
/// an island that has yielded in an earlier pass of the step yields again unless a few sweeps solve
/// it.
///
/// `auto` sweeps with momentum, and runs exact steps where sweeps stall. With friction and a
/// tolerance below 1e-6, sweeps run to a residual of 1e-5, and exact steps follow. An island of up
/// to 1000 points gets exact steps after 300 sweeps. An exact iteration of such an island counts as
/// 20 sweeps, or as one if the residual already meets its tolerance. Slim islands get exact steps
/// after fewer sweeps (solve_auto.hpp).
///
/// Throws std::invalid_argument for an unknown name, settings out of range, or a problem that
/// checkProblem rejects.
Report solve(ContactProblem&, const std::string& solver, const Settings&, Workspace&);

} // namespace rcr

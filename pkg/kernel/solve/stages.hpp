// The stages that complete the solution of an island after the sweeps of all islands together.
#pragma once

#include <string>

#include "problem/solver.hpp"

namespace rcr {

/// Sweeps of all islands of a problem together, the first stage of every solver.
Report sweepTogether(ContactProblem&, const std::string& solver, const Settings&, Workspace&);

/// Returns true if exact steps follow the sweeps of an island that has not converged.
bool takesExactSteps(const std::string& solver, const Settings&);

/// Completes an island, or a problem of one island, after its sweeps: runs the stages of the table
/// in stages.cpp that apply to its state. `before`: impulsesBeforeProbe of the island, if known.
Report complete(ContactProblem& island, const std::string& solver, const Settings&,
        const Report& swept, Workspace&, std::vector<LocalVector> before);

} // namespace rcr

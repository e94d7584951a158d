// The choices of the solver `auto`: how far to sweep an island, and when exact steps follow.
#pragma once

#include "problem/solver.hpp"

namespace rcr {

constexpr int    smallProblem = 1000; // points; all exact steps cost at most some hundred sweeps

/// Settings of the sweeps before exact steps. They aim at the accuracy itself where exact steps may
/// reach it, and at the goal of the island elsewhere.
Settings firstSweepsOfAuto(const Settings&, const IslandShape&);

/// `auto` after the sweeps of an island, which have not converged.
Report continueAuto(
        ContactProblem&, const Settings&, const Report& swept, Workspace&);

} // namespace rcr

// Tests of solved islands: whether contacts must yield, and whether impulses add energy.
#pragma once

#include <vector>

#include "problem/solver.hpp"

namespace rcr {

using PointIterator = std::vector<std::int32_t>::const_iterator;

/// Returns true if contacts have yielded in an earlier pass of the step.
bool hasYielded(const ContactProblem&);

/// Returns true if a point must yield, whether its island has converged or not.
bool mustYieldAt(const ContactProblem&, std::size_t point, const Settings&);

/// Returns true if contacts must yield. Also tests converged solutions: a wedge can have
/// impulses so large that both relative errors are small. `probes`: also sweeps a copy of the
/// problem to look for impulses that diverge, unless the growth since `before` gives no hint of it.
/// No `before`: unknown.
bool mustYield(const Report&, const ContactProblem&, const Settings&, Workspace&,
        const std::vector<LocalVector>& before, bool probes = true);

/// True if the impulses grew much in the last sweeps, or if their growth is NaN or unknown.
bool mayDiverge(const Report&, const Settings&);

/// Heuristic filter before exceedsEnergyBound. It uses the mass of all bodies of an island and the
/// RMS |u_free| of its points. So it may overlook a wedge in a large island.
bool mayExceedEnergyBound(const Report&);

/// Returns true if a solution with small errors is none. The residual omits blocked contacts, and
/// growing impulses lower it.
bool isFalseSolution(const ContactProblem&, const Settings&);

/// Returns true if the impulses of these points, those of an island, would add energy to the step:
/// the cost ½ pᵀWp + p · (u_free + b_n n) [J/m] is positive. Frictionless solutions minimise it; zero
/// impulses cost 0. Solvers that start far from the solution can end with such impulses.
bool hasPositiveCost(const ContactProblem&, PointIterator first, PointIterator last);

} // namespace rcr

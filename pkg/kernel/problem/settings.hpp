// Settings of all solvers (solver.hpp).
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "problem/error_estimate.hpp"
#include "problem/reductions.hpp"
#include "problem/yielding.hpp"

namespace rcr {

/// When sweeps give up: the residual has met its tolerance and other criteria have not, or its
/// trend takes too long to it.
struct Trend {
	int from       = 0; // sweeps before the test; 0: no test
	int mostSweeps = 0; // that the trend may take
	int mostBeyond = 0; // sweeps for other criteria, once the residual has met its tolerance
};

struct Settings {
	double tolerance = 1e-4; // residual at which to stop [-]; 0: never

	/// Estimated error at which to stop, together with the residual (error_estimate.hpp) [-].
	/// IslandShape::goal relaxes it for dense packings with friction. Infinity: no test.
	double accuracy = std::numeric_limits<double>::infinity();

	/// Largest creep of an island [m/s] (residual.hpp).
	double creepTolerance = std::numeric_limits<double>::infinity();

	/// Rounding error of velocities [m/s]. An island whose RMS error w_nn |p − P_K(…)| is smaller
	/// counts as solved, for example bodies that fly together.
	double roundingVelocity = 0;

	/// Stop criterion of the paper: relative change of the mean normal impulse between two
	/// evaluations [-]. The solver stops at the criterion that is met first. A warm start meets
	/// 1e-3 already at a residual of 1e-2. 0: not used.
	double meanForceChange = 0;

	/// Returns true if residual, creep and estimated error meet their limits. Tolerance 0 is
	/// never met.
	bool areMet(double residual, double creep, double errorEstimate) const
	{
		return tolerance > 0 && residual <= tolerance && creep <= creepTolerance
		        && errorEstimate <= accuracy;
	}

	int maxIterations = 1000; // sweeps over all points
	int minIterations = 0;    // sweeps before any other criterion may stop the solver
	int checkInterval = 10;   // sweeps between two evaluations of the stop criteria
	int stallSweeps   = 0;    // stops after so many sweeps without a new lowest residual; 0: never
	Trend trend;
	int threads       = 1;
	int lanes         = 0; // kernels: scalar (1), AVX2 (4), the processor's widest (8, 0)

	Reductions reductions;

	/// Contacts yield if the step has no solution, or if an impulse exceeds the yield impulse
	/// (step/yield_bounds.hpp). Compliance 0: contacts never yield.
	Yielding yielding;

	/// The same of islands without a drive of their own. The bounds of a drive elsewhere must not
	/// change their solution.
	Yielding undriven;

	/// A solution is known to exist. No contact yields, and no test looks for the lack of one.
	bool solutionExists = false;

	bool mayYield() const { return yielding.compliance > 0 && !solutionExists; }

	/// These settings with the goal of an island as accuracy.
	Settings forGoalOf(const IslandShape& shape) const
	{
		Settings own = *this;
		own.accuracy = shape.goal(accuracy);
		return own;
	}
};

const std::vector<std::string>& solverNames();

/// Throws std::invalid_argument for an unknown name or settings out of range.
void checkSettings(const std::string& solver, const Settings&);

} // namespace rcr

// What the sweep solvers share: the problem taken in and given back, and the decision to stop.
#pragma once

#include <limits>

#include "packed_problem.hpp"
#include "solver.hpp"

namespace rcr {

/// Counts sweeps, evaluates the criteria of the settings every few of them, and says when to stop.
class StopTest {
public:
	StopTest(PackedProblem& packed, const Settings& settings) : packed_(packed), settings_(settings) { }

	/// To be asked before each sweep.
	bool reached();
	/// The criteria at the end, of what was written.
	Report report();

private:
	void measure();
	bool met() const;
	bool stalled();

	PackedProblem&  packed_;
	const Settings& settings_;
	Report          report_;
	double          meanForceChange_ = std::numeric_limits<double>::infinity();
	double          normal_          = 0; // Σ p_n at the last evaluation
	double          lowest_          = std::numeric_limits<double>::infinity(); // residual
	int             sweeps_ = 0, lowestAt_ = 0;
	bool            measured_        = false;
};

/// Takes the problem in, calls iterate(packed, stop) in a team of threads, gives the solution back.
template <class Iterate> Report solveBySweeps(ContactProblem& problem, const Settings& settings, Workspace& workspace, Iterate iterate)
{
	PackedProblem& packed = workspace.packed();
	Report         report;
	packed.team.run(settings.threads, [&] {
		packed.load(problem, settings.lanes);
		StopTest stop(packed, settings);
		iterate(packed, stop);
		packed.store(problem);
		report = stop.report();
	});
	return report;
}

} // namespace rcr

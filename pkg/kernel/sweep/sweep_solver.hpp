// What the sweep solvers share: the problem taken in and given back, and the decision to stop.
#pragma once

#include <limits>
#include <vector>

#include "sweep/packed_problem.hpp"
#include "problem/solver.hpp"

namespace rcr {

/// What says that sweeps may stop.
struct Criteria {
	double residual = 0, violation = 0; // as in Report
	double meanForceChange = std::numeric_limits<double>::infinity();

	bool met(const Settings&) const;
};

/// Counts the sweeps of an island, evaluates the criteria of the settings every few of them, and says when to stop.
class StopTest {
public:
	StopTest(PackedIsland& island, const Settings& settings) : island_(island), settings_(settings) { }

	/// To be asked before each sweep.
	bool   reached();
	/// Whether the island meets the criteria of these settings as it is.
	bool   meets(const Settings&);
	int    sweeps() const { return sweeps_; }
	double meanForceChange() const { return criteria_.meanForceChange; }

private:
	void measure();
	bool stalled();

	PackedIsland&   island_;
	const Settings& settings_;
	Criteria        criteria_;
	double          normal_ = 0; // Σ p_n at the last evaluation
	double          lowest_ = std::numeric_limits<double>::infinity(); // residual
	int             sweeps_ = 0, lowestAt_ = 0;
	bool            measured_ = false;
};

/// How an island was left.
struct IslandEnd {
	int    sweeps;
	double meanForceChange; // between sweeps, not by the end
};

/// The criteria at the end, of what was written: of all, and whether each island has met its own.
Report reportOf(PackedProblem&, const Settings&, const std::vector<IslandEnd>&);

std::vector<double> biases(const ContactProblem&);

/// Takes the problem in, calls iterate(island, stop) for each island in a team of threads, gives the solution back.
template <class Iterate> Report solveBySweeps(ContactProblem& problem, const Settings& settings, Workspace& workspace, Iterate iterate)
{
	PackedProblem& packed = workspace.packed();
	Report         report;
	packed.team.run(settings.threads, [&] {
		if (settings.continued) packed.rebias(problem, biases(problem));
		else
			packed.load(problem, settings.lanes, settings.reductions);
		std::vector<IslandEnd> ends(packed.islands());
		packed.forEachIsland([&](PackedIsland&& island) {
			StopTest stop(island, settings);
			iterate(island, stop);
			ends[island.number()] = { stop.sweeps(), stop.meanForceChange() };
		});
		packed.store(problem);
		report = reportOf(packed, settings, ends);
	});
	return report;
}

} // namespace rcr

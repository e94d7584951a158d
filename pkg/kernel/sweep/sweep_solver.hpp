// Common parts of the sweep solvers: loading, storing, the stop test of an island, the report.
#pragma once

#include "problem/solver.hpp"
#include "sweep/packed_island.hpp"
#include "sweep/stop_test.hpp"

namespace rcr {

/// Sums over the points of an island or of the whole problem.
struct Sums {
	Measures measures; // of the stored solution
	double   freeVelocity2 = 0, mass = 0;
	/// ‖Δp‖² over the last `probeSweeps` sweeps. Infinite unless the island used all iterations.
	double change2 = 0;
	int    points  = 0;
};

/// The state of an island after its last sweep.
struct IslandEnd {
	Sums        sums;
	int         sweeps;
	Criteria    criteria; // after the last sweep
	Settings    settings; // of the island
	IslandShape shape;
};

/// The stop test of an island, and its error estimate. The estimate compares the impulses with
/// those of half as many sweeps. Impulses are saved every 2ⁱ and 3·2ⁱ intervals.
class IslandStop {
public:
	/// `settings`: those of the island.
	IslandStop(PackedIsland& island, const Settings& settings);

	/// Call before each sweep. Returns true if the sweeps must stop. An island of one point is
	/// measured after its first sweep, which may solve it.
	bool            mustStop();
	int             sweeps() const { return stop_.sweeps(); }
	const Settings& settings() const { return stop_.settings(); } // of this island
	IslandEnd       end(); // without `measures`; call it after the last sweep

private:
	struct Saved {
		int    sweeps   = 0;
		double residual = 0;
	};

	Criteria measure(); // if floats meet the criteria, measures again in doubles
	Criteria evaluate(bool atEnd);
	double   estimate(const Measures&, double residual, const Saved&, int slot);
	void     saveAtCheckpoint(double residual);

	PackedIsland& island_;
	StopTest      stop_;
	Saved         saved_[2];
	bool          probed_ = false; // impulses were saved `probeSweeps` before the last sweep
	double        normal_ = std::numeric_limits<double>::quiet_NaN(); // last Σ p_n, if any
};

/// The report of the solution. It has converged if each island meets the criteria.
Report reportOf(const std::vector<IslandEnd>&, const Settings&);

/// Loads the problem, calls iterate(island, stop) for each island, and stores the solution. Small
/// islands are solved in parallel; large ones follow one by one, each on all threads.
template <class Iterate>
Report solveBySweeps(ContactProblem& problem, const Settings& settings, Workspace& workspace,
        Iterate iterate, IslandSettings ofIsland = settingsForGoal)
{
	PackedProblem& packed = workspace.packed();
	Report         report;
	packed.team.run(settings.threads, [&] {
		packed.load(problem, settings.lanes, settings.reductions);
		std::vector<IslandEnd> ends(packed.islands());
		packed.forEachIsland([&](PackedIsland&& island) {
			IslandStop stop(island, ofIsland(settings, island.shape()));
			iterate(island, stop);
			ends[island.number()] = stop.end();
		});
		packed.store(problem);
		packed.forEachIsland([&](PackedIsland&& island) {
			ends[island.number()].sums.measures = island.measure();
		});
		report = reportOf(ends, settings);
	});
	return report;
}

} // namespace rcr

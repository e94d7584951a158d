// Common parts of the sweep solvers: loading, storing, the stop test of an island, the report.
#pragma once

#include "problem/solver.hpp"
#include "sweep/packed_island.hpp"
#include "sweep/stop_test.hpp"

namespace rcr {

/// The stop test of an island.
class IslandStop {
public:
	IslandStop(PackedIsland& island, const Settings& settings)
	        : island_(island), stop_(settingsFor(island, settings))
	{
	}

	/// Call before each sweep. Returns true if the sweeps must stop. An island of one point is
	/// measured after its first sweep, which solves it.
	bool mustStop()
	{
		return stop_.mustStop(
		        stop_.sweeps() == 1 && island_.points() == 1, [this] { return measure(); });
	}
	int             sweeps() const { return stop_.sweeps(); }
	const Settings& settings() const { return stop_.settings(); } // of this island
	double          meanForceChange() const { return stop_.criteria().meanForceChange; }

private:
	static Settings settingsFor(const PackedIsland&, const Settings&);

	Criteria measure(); // confirms floats by doubles
	Criteria evaluate();

	PackedIsland& island_;
	StopTest      stop_;
	double        normal_   = 0; // Σ p_n at the last evaluation
	bool          measured_ = false;
};

/// The state of an island after its last sweep.
struct IslandEnd {
	int    sweeps;
	double meanForceChange; // of the last evaluation [-]
	double velocityFloor;   // of its settings [-]
	/// ‖Δp‖² over the last `probeSweeps` sweeps. Infinite unless the island used all iterations.
	double change2;
};

/// The report of the stored solution. It has converged if each island meets the criteria.
Report reportOf(PackedProblem&, const Settings&, const std::vector<IslandEnd>&);

/// Loads the problem, calls iterate(island, stop) for each island, and stores the solution. Small
/// islands are solved in parallel; shared ones follow one by one, each on all threads.
template <class Iterate>
Report solveBySweeps(
        ContactProblem& problem, const Settings& settings, Workspace& workspace, Iterate iterate)
{
	PackedProblem& packed = workspace.packed();
	Report         report;
	packed.team.run(settings.threads, [&] {
		if (settings.sameProblem && packed.loaded()) packed.reload(problem);
		else
			packed.load(problem, settings.lanes, settings.reductions);
		std::vector<IslandEnd> ends(packed.islands());
		packed.forEachIsland([&](PackedIsland&& island) {
			IslandStop stop(island, settings);
			iterate(island, stop);
			const Settings& own   = stop.settings();
			const bool      known = island.hasSavedImpulses() && stop.sweeps() == own.maxIterations;
			const double    change2 = known ? island.changeSinceSaved()
			                                : std::numeric_limits<double>::infinity();
			ends[island.number()]
			        = { stop.sweeps(), stop.meanForceChange(), own.velocityFloor, change2 };
		});
		packed.store(problem);
		report = reportOf(packed, settings, ends);
	});
	return report;
}

} // namespace rcr

// What the sweep solvers share: the problem taken in and given back, and the decision to stop.
#pragma once

#include <limits>
#include <vector>

#include "problem/solver.hpp"
#include "sweep/packed_problem.hpp"
#include "sweep/stop_test.hpp"

namespace rcr {

/// The stop test of an island.
class IslandStop {
public:
	IslandStop(PackedIsland& island, const Settings& settings) : island_(island), settings_(settings), stop_(settings) { }

	/// Asked before each sweep. One sweep solves an island of one point.
	bool reached()
	{
		return stop_.reached(stop_.sweeps() == 1 && island_.points() == 1, [this] { return measure(); });
	}
	/// Whether the island meets the criteria of these settings as it is.
	bool   meets(const Settings& settings) { return measure().met(settings); }
	int    sweeps() const { return stop_.sweeps(); }
	double meanForceChange() const { return stop_.criteria().meanForceChange; }

private:
	Criteria measure(); // in doubles where floats say that this is the end
	Criteria evaluate();

	PackedIsland&   island_;
	const Settings& settings_;
	StopTest        stop_;
	double          normal_   = 0; // Σ p_n at the last evaluation
	bool            measured_ = false;
};

/// How an island was left.
struct IslandEnd {
	int    sweeps;
	double meanForceChange; // between sweeps, not by the end
	double change2;         // of the impulses in the last `probeSweeps` sweeps of all that were allowed; infinite: not known
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
		if (settings.sameProblem) packed.rebias(problem, biases(problem));
		else
			packed.load(problem, settings.lanes, settings.reductions);
		std::vector<IslandEnd> ends(packed.islands());
		packed.forEachIsland([&](PackedIsland&& island) {
			IslandStop stop(island, settings);
			iterate(island, stop);
			const bool known = island.remembers() && stop.sweeps() == settings.maxIterations;
			ends[island.number()] = { stop.sweeps(), stop.meanForceChange(), known ? island.changeSinceRemembered() : std::numeric_limits<double>::infinity() };
		});
		packed.store(problem);
		report = reportOf(packed, settings, ends);
	});
	return report;
}

} // namespace rcr

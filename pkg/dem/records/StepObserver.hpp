// Records mean forces and counts of steps for a script, over a run or in equal intervals.
//
// `record` and the take functions lock, so Python may call them during a run.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "dem/records/StepMonitor.hpp"
#include "dem/transfer/gather.hpp"

namespace yade {

class StepObserver {
public:
	/// Adds a step. `interval`: number of steps per entry; 0: no entries. `impulses`: contact
	/// impulse on each body [N s]. Throws std::invalid_argument if an id is not that of a body or
	/// clump of the scene.
	void record(const StepOutcome&, const std::vector<int>& ids, int interval,
	        const std::vector<rcr::PlanarVector>& impulses, const rcr::Step&, const SceneHandles&);

	/// Starts new means and a new entry, for a step of another scene.
	void restart();

	/// Means since the last call and the last entry.
	boost::python::dict takeMeans(const std::vector<int>& ids);

	/// Sets the positions of the last entry at the end of a run, before a script moves bodies.
	void setLastPositions(const Scene&);

	/// Entries since the last call. During a run, the newest entry waits for the next call, because
	/// its positions are unknown.
	boost::python::list takeIntervals();

private:
	struct Sums {
		std::vector<int>                 ids;
		int                              interval = 0; // steps of an entry
		long                             steps = 0, iterations = 0, missed = 0, yielded = 0;
		double                           residual = 0, ratioSum = 0, largestRatio = 0;
		std::map<int, rcr::PlanarVector> force; // by body [N, N m]
	};

	struct Interval {
		Sums                     sums;
		StepOutcome              last; // its last step
		std::map<int, rcr::Vec2> position; // at its end, by body [m]
		bool                     placed = false; // positions are known: the next step has begun
	};

	/// Adds a step, to new sums if the ids or the interval have changed.
	static void add(Sums&, const StepOutcome&, const std::vector<int>& ids, int interval,
	        const std::vector<rcr::PlanarVector>& impulses, double dt);
	static boost::python::dict dictOf(const Sums&, const std::vector<int>& ids);
	/// Sets the positions of the last interval. `positionOf` returns nothing for an erased body.
	void setLastPositions(const std::function<std::optional<rcr::Vec2>(int id)>& positionOf);

	std::mutex            mutex_;
	Sums                  means_, entry_;
	std::vector<Interval> intervals_;
};

} // namespace yade

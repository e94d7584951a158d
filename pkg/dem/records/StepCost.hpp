// Size of the last problem, how it was solved, and the wall time of all stages.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "dem/yadeHeaders.hpp"
#include "kernel/parallel/timed.hpp"
#include "kernel/problem/reductions.hpp"

namespace yade {

/// ContactDynamics.model.
struct StepModel {
	rcr::ModelSummary summary;
	double            work            = 0;                // sweeps × points of the step
	Vector2r          meanStretchRate = Vector2r::Zero(); // along x and y [1/s]
	long              arraySteps      = 0;
	std::string       enginesReason; // why YADE's engines take the next step; empty: arrays take it

	boost::python::dict dict() const
	{
		boost::python::dict model;
		summary.forEachEntry([&](const char* name, auto value) { model[name] = value; });
		const double x = double(meanStretchRate[0]), y = double(meanStretchRate[1]);
		model["work"]              = work;
		model["mean_stretch_rate"] = boost::python::make_tuple(x, y);
		model["array_steps"]       = arraySteps;
		model["engines"]           = enginesReason;
		return model;
	}
};

/// Wall time of the stages of ContactDynamics, summed over its steps [s].
class StageTimes {
public:
	void add(const std::string& stage, double seconds)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		seconds_[stage] += seconds;
	}

	boost::python::dict dict() const
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		boost::python::dict               result;
		for (const auto& [stage, seconds] : seconds_)
			result[stage] = seconds;
		return result;
	}

private:
	mutable std::mutex            mutex_;
	std::map<std::string, double> seconds_;
};

} // namespace yade

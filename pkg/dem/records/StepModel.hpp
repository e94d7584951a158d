// Size of the last problem and how it was solved: ContactDynamics.model.
#pragma once

#include <mutex>

#include "dem/yadeHeaders.hpp"
#include "kernel/problem/reductions.hpp"

namespace yade {

class StepModel {
public:
	/// `work`: sweeps × points of the step. `meanStretchRate`: along x and y [1/s].
	/// `enginesReason`: reason for which YADE's engines take the next step; empty: none.
	void set(const rcr::ModelSummary& summary, double work, const Vector2r& meanStretchRate,
	        long arraySteps, const std::string& enginesReason)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		summary_ = summary, work_ = work, meanStretchRate_ = meanStretchRate;
		arraySteps_ = arraySteps, enginesReason_ = enginesReason;
	}

	/// Python may call it during a run.
	boost::python::dict dict() const
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		boost::python::dict               model;
		summary_.forEachEntry([&](const char* name, auto value) { model[name] = value; });
		const double x = double(meanStretchRate_[0]), y = double(meanStretchRate_[1]);
		model["work"]              = work_;
		model["mean_stretch_rate"] = boost::python::make_tuple(x, y);
		model["array_steps"]       = arraySteps_;
		model["engines"]           = enginesReason_;
		return model;
	}

private:
	mutable std::mutex mutex_;
	rcr::ModelSummary  summary_;
	double             work_            = 0;
	Vector2r           meanStretchRate_ = Vector2r::Zero();
	long               arraySteps_      = 0;
	std::string        enginesReason_;
};

} // namespace yade

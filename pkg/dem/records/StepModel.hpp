// Size of the last problem and how it was solved: ContactDynamics.model.
#pragma once

#include <mutex>

#include "dem/yadeHeaders.hpp"
#include "kernel/problem/reductions.hpp"

namespace yade {

class StepModel {
public:
	/// `work`: sweeps × points of the step. `meanStretchRate`: along x and y [1/s].
	void setProblem(const rcr::ModelSummary& summary, double work, const Vector2r& meanStretchRate)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		summary_ = summary, work_ = work, meanStretchRate_ = meanStretchRate;
	}

	/// `reason`: reason for which YADE's engines take the next step; empty: none.
	void setArrays(long stepsInArrays, const std::string& reason)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		stepsInArrays_ = stepsInArrays, enginesReason_ = reason;
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
		model["arrays"]            = stepsInArrays_;
		model["engines"]           = enginesReason_;
		return model;
	}

private:
	mutable std::mutex mutex_;
	rcr::ModelSummary  summary_;
	double             work_            = 0;
	Vector2r           meanStretchRate_ = Vector2r::Zero();
	long               stepsInArrays_   = 0;
	std::string        enginesReason_;
};

} // namespace yade

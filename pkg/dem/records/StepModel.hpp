// Size of the last problem and how it was solved: ContactDynamics.model.
#pragma once

#include <mutex>

#include "dem/yadeHeaders.hpp"
#include "kernel/problem/reductions.hpp"

namespace yade {

class StepModel {
public:
	/// `work`: sweeps × points of the step. `meanStretchRate`: along x and y [1/s].
	void setProblem(const rcr::ModelSummary&, double work, const Vector2r& meanStretchRate);
	/// `reason`: reason for which YADE's engines take the next step; empty: none.
	void setArrays(long stepsInArrays, const std::string& reason);

	boost::python::dict dict() const; // Python may call it during a run

private:
	mutable std::mutex mutex_;
	rcr::ModelSummary  summary_;
	double             work_            = 0;
	Vector2r           meanStretchRate_ = Vector2r::Zero();
	long               stepsInArrays_   = 0;
	std::string        enginesReason_;
};

} // namespace yade

#include "dem/records/StepModel.hpp"

namespace yade {

void StepModel::setProblem(
        const rcr::ModelSummary& summary, double work, const Vector2r& meanStretchRate)
{
	const std::lock_guard<std::mutex> lock(mutex_);
	summary_ = summary, work_ = work, meanStretchRate_ = meanStretchRate;
}

void StepModel::setArrays(long stepsInArrays, const std::string& reason)
{
	const std::lock_guard<std::mutex> lock(mutex_);
	stepsInArrays_ = stepsInArrays, enginesReason_ = reason;
}

boost::python::dict StepModel::dict() const
{
	const std::lock_guard<std::mutex> lock(mutex_);
	boost::python::dict               model;
	summary_.forEachEntry([&](const char* name, auto value) { model[name] = value; });
	model["work"]         = work_;
	model["mean_stretch_rate"]
	        = boost::python::make_tuple(double(meanStretchRate_[0]), double(meanStretchRate_[1]));
	model["arrays"]  = stepsInArrays_;
	model["engines"] = enginesReason_;
	return model;
}

} // namespace yade

// Size of the last problem and how it was solved: ContactDynamics.model.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/problem/reductions.hpp"

namespace yade {

struct StepModel {
	rcr::ModelSummary summary;
	double            work            = 0;                // sweeps × points of the step
	Vector2r          meanStretchRate = Vector2r::Zero(); // along x and y [1/s]
	long              arraySteps      = 0;
	std::string       enginesReason; // YADE's engines take the next step; empty: they do not

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

} // namespace yade

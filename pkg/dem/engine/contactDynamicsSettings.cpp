// Attributes of ContactDynamics: validity, settings of the solver, flow of overdamped bodies.
#include "dem/engine/ContactDynamics.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "kernel/step/mean_stretch.hpp"

namespace yade {

constexpr int    mostThreads      = 1024; // more exhaust the memory of a process
constexpr int    mostIterations   = 10'000'000; // of a solve; no sum of them overflows

std::string ContactDynamics::attributeError() const
{
	const auto message = [](const char* name, const std::string& given, const char* expected) {
		return std::string("ContactDynamics.") + name + " = " + given + "; expected " + expected;
	};
	using errors::text;
	if (!(correction >= 0 && correction <= 1))
		return message("correction", text(correction), "a fraction of the overlap, 0 to 1.");
	if (!(accuracy > 0))
		return message("accuracy", text(accuracy),
		        "a relative error > 0, 0.01 by default; math.inf switches the test off.");
	if (!math::isfinite(tolerance))
		return message("tolerance", text(tolerance),
		        "a finite residual, 1e-4 by default; 0 runs maxIterations.");
	if (observeEvery < 0)
		return message("observeEvery", std::to_string(observeEvery),
		        "a number of steps, or 0 for no entries.");
	if (threads < 0 || threads > mostThreads)
		return message("threads", std::to_string(threads),
		        "at most 1024 threads, or 0 for as many as YADE has.");
	if (!(yieldCompliance >= 0 && math::isfinite(yieldCompliance)))
		return message("yieldCompliance", text(yieldCompliance),
		        "a finite factor ≥ 0, 1 by default; with 0 contacts never yield.");
	if (flow != Matrix3r::Zero() && !(overdamped && math::isfinite(flow.sum())))
		return "ContactDynamics.flow is not zero; expected finite entries, and overdamped = True: "
		       "other bodies keep their velocities.";
	if (trackMeanStretch && !overdamped)
		return message("trackMeanStretch", "True",
		        "overdamped = True: other bodies keep their velocities.");
	try {
		const rcr::StepSettings s = stepSettings();
		rcr::checkSettings(s.solver, rcr::passSettings(s, {}));
	} catch (const std::invalid_argument& error) {
		return std::string("ContactDynamics: ") + error.what();
	}
	return {};
}

int ContactDynamics::solverThreads() const { return threads > 0 ? threads : omp_get_max_threads(); }

rcr::StepSettings ContactDynamics::stepSettings() const
{
	rcr::StepSettings s;
	s.solver               = get<&ContactDynamics::solver>();
	s.pass.tolerance       = double(tolerance);
	s.pass.maxIterations   = std::min(maxIterations, mostIterations);
	s.pass.accuracy        = double(accuracy);
	s.pass.meanForceChange = double(meanForceChange);
	s.pass.threads         = solverThreads();
	s.pass.lanes           = lanes;
	s.correction           = double(correction);
	s.yieldCompliance      = double(yieldCompliance);
	return s;
}

void ContactDynamics::setStartFlow()
{
	step_.startFlow = plane::flowOf(flow);
	step_.startFlow.gradient[0][0] += double(meanStretchRate[0]);
	step_.startFlow.gradient[1][1] += double(meanStretchRate[1]);
}

/// Adds the mean stretch of the step to the flow from which the next step starts.
void ContactDynamics::updateMeanStretch()
{
	const rcr::Vec2 change = rcr::meanStretchRate(step_);
	stretchChange          = Vector2r(change.x, change.y);
	meanStretchRate += stretchChange;
	setStartFlow();
}

} // namespace yade

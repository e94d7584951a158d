// Attributes of ContactDynamics: validity, settings of the solver, flow of overdamped bodies.
#include "dem/engine/ContactDynamics.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "kernel/step/mean_stretch.hpp"

namespace yade {

constexpr int    mostThreads      = 1024; // more exhaust the memory of a process
constexpr int    sweepsOfNextPass = 10;   // least number of sweeps of a further pass
constexpr int    sweepsAllowed    = 100;  // those that a further pass may take in any case
constexpr double fineTolerance    = 1e-6; // below it, a further pass may use all iterations
// factor of maxIterations while grains are squeezed: a lack of sweeps must not look like a jam
constexpr int    squeezedEffort   = 10;
constexpr int    mostIterations   = 10'000'000; // of a solve; no sum of them overflows

std::string ContactDynamics::attributeError() const
{
	const auto message = [](const char* name, const std::string& given, const char* expected) {
		return std::string("ContactDynamics.") + name + " = " + given + "; expected " + expected;
	};
	using validation::text;
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
		rcr::checkSettings(get<&ContactDynamics::solver>(), settings({}));
	} catch (const std::invalid_argument& error) {
		return std::string("ContactDynamics: ") + error.what();
	}
	return {};
}

int ContactDynamics::solverThreads() const { return threads > 0 ? threads : omp_get_max_threads(); }

rcr::Settings ContactDynamics::settings(const rcr::YieldBounds& bounds) const
{
	rcr::Settings s;
	s.tolerance          = double(tolerance);
	s.maxIterations      = std::min(maxIterations, mostIterations);
	s.accuracy           = double(accuracy);
	s.meanForceChange    = double(meanForceChange);
	s.threads            = solverThreads();
	s.lanes              = lanes;
	s.yielding           = bounds.yielding;
	s.undriven           = rcr::YieldBounds().yielding;
	s.yielding.compliance *= double(yieldCompliance);
	s.undriven.compliance *= double(yieldCompliance);
	s.yielding.yieldImpulse /= double(yieldCompliance); // infinite for 0
	return s;
}

rcr::Settings ContactDynamics::settingsOfFirstPass(const rcr::YieldBounds& bounds)
{
	rcr::Settings s    = settings(bounds);
	s.roundingVelocity  = step_.roundingVelocity(workspace_.team());
	if (!overdamped) s.velocityTolerance = rcr::driftVelocity(step_); // else no overlap remains
	if (monitor.jam.active()) s.maxIterations *= squeezedEffort;
	return s;
}

/// A further pass corrects a few contacts. The residual over all contacts would not show them, so
/// the pass runs at least ten sweeps. All passes share the iterations of the step, except for fine
/// tolerances.
rcr::Settings ContactDynamics::settingsOfNextPass(rcr::Settings s, PassOutcome outcome) const
{
	if (tolerance >= fineTolerance)
		s.maxIterations = std::max(s.maxIterations - iterations, sweepsAllowed);
	s.minIterations = std::min(sweepsOfNextPass, s.maxIterations);
	s.sameProblem   = outcome != PassOutcome::contactsAdded;
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

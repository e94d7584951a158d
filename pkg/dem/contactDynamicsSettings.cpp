// The attributes of ContactDynamics as settings of the solver.
#include "ContactDynamics.hpp"

namespace yade {

namespace {
	constexpr int    furtherSweeps = 10;   // of a further pass …
	constexpr double fine          = 1e-6; // … unless a residual below this is wanted
}

std::string ContactDynamics::wrong() const
{
	if (!(correction >= 0 && correction <= 1)) return "ContactDynamics.correction = " + gate::text(correction) + "; wanted a share of the overlap, 0 to 1.";
	if (!(kinematicTolerance > 0))
		return "ContactDynamics.kinematicTolerance = " + gate::text(kinematicTolerance)
		        + "; wanted a share > 0 of the relative velocities, 0.01 by default; math.inf for no test.";
	if (!math::isfinite(tolerance)) return "ContactDynamics.tolerance = " + gate::text(tolerance) + "; wanted a finite residual, 1e-4 by default; 0 runs maxIterations.";
	if (minIterations > maxIterations)
		return "ContactDynamics.minIterations = " + std::to_string(minIterations) + "; wanted at most maxIterations = " + std::to_string(maxIterations) + ".";
	if (observeEvery < 0) return "ContactDynamics.observeEvery = " + std::to_string(observeEvery) + "; wanted 0, none, or a number of steps.";
	if (threads < 0) return "ContactDynamics.threads = " + std::to_string(threads) + "; wanted 0, as many as YADE has, or more.";
	if (!(yieldCompliance >= 0 && math::isfinite(yieldCompliance)))
		return "ContactDynamics.yieldCompliance = " + gate::text(yieldCompliance) + "; wanted a finite factor ≥ 0, 1 by default; 0: contacts never yield.";
	if (flow != Matrix3r::Zero() && !(overdamped && math::isfinite(flow.sum())))
		return "ContactDynamics.flow is not zero; wanted finite, and only with overdamped = True: other bodies keep their velocities.";
	if (trackMeanStretch && !overdamped) return "ContactDynamics.trackMeanStretch = True; wanted only with overdamped = True: other bodies keep their velocities.";
	try {
		rcr::checkSettings(solverName(), settings({}));
	} catch (const std::invalid_argument& error) {
		return std::string("ContactDynamics: ") + error.what();
	}
	return {};
}

rcr::Settings ContactDynamics::settings(const rcr::Drive& drive) const
{
	rcr::Settings s;
	s.tolerance       = double(tolerance);
	s.maxIterations   = maxIterations;
	s.minIterations   = minIterations;
	s.kinematicTolerance       = double(kinematicTolerance);
	s.meanForceChange = double(meanForceChange);
	s.threads         = solverThreads();
	s.lanes           = lanes;
	s.yieldCompliance      = double(yieldCompliance) * drive.compliance;
	s.yieldImpulse     = drive.yieldImpulse / double(yieldCompliance); // 0: infinite
	s.reductions      = rcr::Reductions::of(reductions);
	return s;
}

/// A further pass corrects a few contacts. The residual over all contacts would not show them, so the pass runs a fixed ten sweeps,
/// enough for their neighbourhood. All passes share the iterations of the step; where fine residuals are wanted, each has all of them: ten
/// would leave what they changed at 1e-3.
rcr::Settings ContactDynamics::settingsOfFurtherPass(rcr::Settings s) const
{
	s.maxIterations = tolerance < fine ? maxIterations : std::max(maxIterations - iterations, furtherSweeps);
	s.minIterations = std::min(std::max(minIterations, furtherSweeps), s.maxIterations);
	return s;
}

} // namespace yade

#include "sweep_solver.hpp"

#include <algorithm>
#include <cmath>

#include "residual.hpp"

namespace rcr {

Workspace::Workspace() : packed_(std::make_unique<PackedProblem>()) { }
Workspace::~Workspace() = default;
Team& Workspace::team() { return packed_->team; }
int Workspace::layouts() const { return packed_->layouts(); }
double Workspace::layoutSeconds() const { return packed_->layoutSeconds(); }

bool StopTest::reached()
{
	bool stop = sweeps_ >= settings_.maxIterations;
	if (!stop && sweeps_ >= settings_.minIterations && sweeps_ % settings_.checkInterval == 0) {
		measure();
		stop = met() || stalled();
	}
	if (!stop) ++sweeps_;
	return stop;
}

bool StopTest::met() const
{
	return (report_.reached(settings_) && report_.violation <= settings_.violation) || meanForceChange_ < settings_.meanForceChange;
}

bool StopTest::stalled()
{
	if (report_.residual < lowest_) {
		lowest_   = report_.residual;
		lowestAt_ = sweeps_;
	}
	return settings_.stallSweeps > 0 && sweeps_ - lowestAt_ >= settings_.stallSweeps;
}

Report StopTest::report()
{
	const double change = meanForceChange_; // between sweeps, not by the end
	measure();
	meanForceChange_   = change;
	report_.iterations = sweeps_;
	report_.converged  = met() || (settings_.tolerance == 0 && report_.residual == 0);
	return report_;
}

void StopTest::measure()
{
	const Measures m  = packed_.measure();
	report_.residual  = relativeError(m.error2, m.impulse2, m.stopping2);
	report_.violation = kinematicError(m.violation2, m.velocity2, packed_.freeVelocity2(), settings_.rest);
	if (measured_) meanForceChange_ = std::abs(m.normal - normal_) / m.normal; // NaN without any force: not met
	normal_   = m.normal;
	measured_ = true;
}

} // namespace rcr

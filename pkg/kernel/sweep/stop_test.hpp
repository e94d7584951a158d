// The decision to stop sweeping, the same for all sweep solvers.
#pragma once

#include <algorithm>
#include <limits>

#include "problem/solver.hpp"

namespace rcr {

/// The quantities that may stop the sweeps, as in Report and Settings.
struct Criteria {
	double residual        = 0; // [-]
	double violation       = 0; // [-]
	double meanForceChange = std::numeric_limits<double>::infinity(); // [-]

	bool met(const Settings& settings) const
	{
		const bool accurate = settings.tolerance > 0 && residual <= settings.tolerance; // 0 asks for all iterations
		return (accurate && violation <= settings.kinematicTolerance) || meanForceChange < settings.meanForceChange;
	}
};

/// Counts sweeps, has the criteria measured every `checkInterval` of them, and stops where these are met, where the residual
/// has reached no new low in `stallSweeps`, and after `maxIterations`. Not before `first` sweeps, nor `minIterations`.
class StopTest {
public:
	explicit StopTest(const Settings& settings, int first = 0) : settings_(settings), first_(std::max(first, settings.minIterations)) { }

	/// Asked before each sweep. `measure()` gives the criteria; `early` has them measured before the interval is over.
	template <class Measure> bool reached(bool early, Measure measure)
	{
		if (sweeps_ >= settings_.maxIterations) return true;
		if (sweeps_ >= first_ && (early || sweeps_ % settings_.checkInterval == 0)) {
			criteria_   = measure();
			measuredAt_ = sweeps_;
			if (criteria_.met(settings_) || stalled()) return true;
		}
		++sweeps_;
		return false;
	}

	int             sweeps() const { return sweeps_; }
	const Criteria& criteria() const { return criteria_; } // as measured last
	bool            measured() const { return measuredAt_ == sweeps_; } // after the last sweep

private:
	bool stalled()
	{
		if (criteria_.residual < lowest_) {
			lowest_   = criteria_.residual;
			lowestAt_ = sweeps_;
		}
		return settings_.stallSweeps > 0 && sweeps_ - lowestAt_ >= settings_.stallSweeps;
	}

	const Settings& settings_;
	const int       first_;
	Criteria        criteria_;
	double          lowest_ = std::numeric_limits<double>::infinity(); // residual
	int             sweeps_ = 0, measuredAt_ = -1, lowestAt_ = 0;
};

} // namespace rcr

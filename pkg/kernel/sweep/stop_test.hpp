// The stop test of all sweep solvers.
#pragma once

#include <cmath>

#include "problem/settings.hpp"

namespace rcr {

/// Measured values of the quantities that may stop the sweeps [-].
struct Criteria {
	double residual        = 0;
	double creep           = 0; // residual.hpp [m/s]
	double errorEstimate   = unknownError;
	double meanForceChange = std::numeric_limits<double>::infinity();

	bool met(const Settings& settings) const
	{
		return settings.areMet(residual, creep, errorEstimate)
		        || meanForceChange < settings.meanForceChange;
	}
};

/// Counts sweeps. From `minIterations` on, it evaluates the criteria every `checkInterval` sweeps.
/// Sweeps must stop if the criteria are met, or after `maxIterations`. They also stop if the
/// residual has had no new minimum in `stallSweeps` sweeps, or if its trend misses the tolerance.
class StopTest {
public:
	explicit StopTest(const Settings& settings) : settings_(settings) { }

	/// Call once before each sweep. Returns true if the sweeps must stop. `measure()` returns the
	/// criteria. `early`: evaluates them before this sweep too.
	template <class Measure> bool mustStop(bool early, Measure measure)
	{
		if (sweeps_ >= settings_.maxIterations) return true;
		if (sweeps_ >= settings_.minIterations
		        && (early || sweeps_ % settings_.checkInterval == 0)) {
			criteria_ = measure();
			recordLowest();
			if (criteria_.met(settings_) || stalled() || trendMisses()) return true;
		}
		++sweeps_;
		return false;
	}

	int             sweeps() const { return sweeps_; }
	const Settings& settings() const { return settings_; }
	const Criteria& criteria() const { return criteria_; } // of the last evaluation

private:
	void recordLowest()
	{
		if (criteria_.residual < lowest_) {
			lowest_   = criteria_.residual;
			lowestAt_ = sweeps_;
		}
		if (lowest_ > settings_.tolerance) missedAt_ = sweeps_;
		if (settings_.trend.from > 0) lowestBy_.push_back(lowest_);
	}

	bool stalled() const
	{
		return settings_.stallSweeps > 0 && sweeps_ - lowestAt_ >= settings_.stallSweeps;
	}

	/// The trend is the fall of the residual since half as many sweeps.
	bool trendMisses() const
	{
		const Trend& trend = settings_.trend;
		if (trend.from == 0 || sweeps_ < trend.from) return false;
		if (lowest_ <= settings_.tolerance) return sweeps_ - missedAt_ >= trend.mostBeyond;
		const double before = lowestBy_[lowestBy_.size() / 2], fall = std::log(before / lowest_);
		const double ahead  = std::log(lowest_ / settings_.tolerance) * 0.5 * sweeps_;
		return !(ahead <= trend.mostSweeps * fall);
	}

	Settings settings_;
	Criteria criteria_;
	std::vector<double> lowestBy_; // lowest residual up to each evaluation
	double   lowest_ = std::numeric_limits<double>::infinity(); // residual
	int      sweeps_ = 0, lowestAt_ = 0, missedAt_ = 0; // the last: residual above its tolerance
};

} // namespace rcr

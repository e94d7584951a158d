// Wall time of a piece of work.
#pragma once

#include <chrono>

namespace rcr {

/// Runs `work`, then calls report(its wall time [s]), also if `work` throws. Returns its result.
template <class Report, class Work> auto timed(Report report, Work work)
{
	using Clock = std::chrono::steady_clock;
	struct Timer {
		Report&                 report;
		const Clock::time_point start = Clock::now();
		~Timer() { report(std::chrono::duration<double>(Clock::now() - start).count()); }
	} timer { report };
	return work();
}

} // namespace rcr

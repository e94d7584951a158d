// Wall time of the stages of ContactDynamics, summed over its steps [s].
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "dem/yadeHeaders.hpp"

namespace yade {

class StageTimes {
public:
	/// Runs `work` and adds its duration to the stage.
	template <class Work> auto measure(const char* stage, Work work)
	{
		using Clock = std::chrono::steady_clock;
		struct Timer {
			StageTimes&             times;
			const char*             stage;
			const Clock::time_point start = Clock::now();
			~Timer() { times.add(stage, std::chrono::duration<double>(Clock::now() - start).count()); }
		} timer { *this, stage };
		return work();
	}

	void add(const std::string& stage, double seconds)
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		seconds_[stage] += seconds;
	}

	boost::python::dict dict() const
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		boost::python::dict               result;
		for (const auto& [stage, seconds] : seconds_)
			result[stage] = seconds;
		return result;
	}

private:
	mutable std::mutex            mutex_;
	std::map<std::string, double> seconds_;
};

} // namespace yade

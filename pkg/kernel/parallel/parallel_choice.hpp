// Chooses serial or parallel execution of a repeated loop by timing.
//
// Helpers do not pay off if their cores are busy, or if moving data between caches takes longer
// than the work saved. The size of a loop does not predict this. Both modes are therefore tried for
// some rounds. The first rounds of a mode fill the caches and do not count. A trial is too short to
// see delays. It therefore compares the mean time of the chosen mode with the fastest time of the
// tried mode times its slowdown: mean over fastest time when that mode was last chosen. Results do
// not depend on the mode.
#pragma once

#include <algorithm>
#include <limits>

namespace rcr {

class ParallelChoice {
public:
	/// Returns true if the next round should run in parallel.
	bool parallel() const { return parallel_; }

	/// Records the time per unit of work of a round in the current mode.
	void record(double time)
	{
		++rounds_;
		if (rounds_ > warmUp) mode_[parallel_].record(time);
		const bool hopeless = rounds_ == warmUp + 1 && time > muchSlower * mode_[!parallel_].mean();
		if (!trying_ && rounds_ == interval) tryOther();
		else if (trying_ && (hopeless || rounds_ == trialRounds))
			choose();
	}

private:
	static constexpr int    warmUp      = 2; // rounds that do not count
	static constexpr int    trialRounds = 8; // rounds of a trial
	// rounds between trials, which cost 2 % of the time if the other mode is twice as slow
	static constexpr int    interval    = 400;
	static constexpr double muchSlower  = 2; // ratio to the other mode that ends a trial at once
	static constexpr double maxSlowdown = 3; // beyond, the load of the machine has changed
	static constexpr double memory      = 0.9; // each trial of a mode multiplies slowdown − 1 by it

	/// Times of a mode since its last start.
	struct Mode {
		double fastest, sum, slowdown = 1;
		int    rounds;

		Mode() { begin(); }
		void   begin() { fastest = std::numeric_limits<double>::infinity(), sum = 0, rounds = 0; }
		void   record(double time) { fastest = std::min(fastest, time), sum += time, ++rounds; }
		double mean() const
		{
			return rounds > 0 ? sum / rounds : std::numeric_limits<double>::infinity();
		}
	};

	void tryOther()
	{
		Mode &chosen = mode_[parallel_], &other = mode_[!parallel_];
		chosen.slowdown = std::clamp(chosen.mean() / chosen.fastest, 1.0, maxSlowdown);
		other.slowdown  = 1 + memory * (other.slowdown - 1);
		other.begin();
		parallel_ = !parallel_;
		trying_   = true;
		rounds_   = 0;
	}

	void choose()
	{
		if (mode_[!parallel_].rounds == 0) return tryOther();
		const Mode &tried = mode_[parallel_], &former = mode_[!parallel_];
		if (tried.slowdown * tried.fastest >= former.mean()) parallel_ = !parallel_;
		mode_[parallel_].begin();
		trying_ = false;
		rounds_ = 0;
	}

	Mode mode_[2]; // serial, parallel
	bool parallel_ = true, trying_ = true;
	int  rounds_ = 0;
};

} // namespace rcr

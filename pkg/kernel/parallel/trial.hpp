// Whether help makes a loop faster: its times with helpers and alone are measured, and the faster way is taken.
//
// A helper is of no use where its core has other work, or where what it touches has to travel between caches for longer than it
// saves. No size of a loop tells that. The first rounds of a way have yet to bring the data to its caches, so a way is tried for some
// rounds in a row, and the first of them do not count. A few rounds tell how fast a way can be, not how often it is held up: of the way
// that is taken all rounds count, and the factor by which they took longer than its fastest applies in its next trials. Results do not depend on the way.
#pragma once

#include <algorithm>
#include <limits>

namespace rcr {

class Trial {
public:
	/// Whether the next round is to be helped: some rounds of each way at first, then as was faster, and now and then some of the other way.
	bool helped() const { return helped_; }

	/// Books a round of the present way and the time that a unit of its work took.
	void book(double time)
	{
		++rounds_;
		if (rounds_ > warmUp) way_[helped_].book(time);
		const bool hopeless = rounds_ == warmUp + 1 && time > farSlower * way_[!helped_].mean();
		if (!trying_ && rounds_ == interval) tryOther();
		else if (trying_ && (hopeless || rounds_ == tried))
			choose();
	}

private:
	static constexpr int    warmUp     = 2;   // rounds
	static constexpr int    tried      = 8;   // rounds of a way on trial …
	static constexpr int    interval   = 400; // … and of the faster one in between: where help doubles the time trials cost 2 %
	static constexpr double farSlower  = 2;   // than the other way: no more rounds are needed to know it
	static constexpr double heldUpMost = 3;   // mean time over the least, beyond which the machine has changed
	static constexpr double memory     = 0.9; // of how much a way was held up when it was last taken, from trial to trial

	/// The rounds since a way was begun.
	struct Way {
		double least, sum, heldUp = 1;
		int    rounds;

		Way() { begin(); }
		void   begin() { least = std::numeric_limits<double>::infinity(), sum = 0, rounds = 0; }
		void   book(double time) { least = std::min(least, time), sum += time, ++rounds; }
		double mean() const { return rounds > 0 ? sum / rounds : std::numeric_limits<double>::infinity(); }
	};

	void tryOther()
	{
		Way &taken = way_[helped_], &other = way_[!helped_];
		taken.heldUp = std::clamp(taken.mean() / taken.least, 1.0, heldUpMost);
		other.heldUp = 1 + memory * (other.heldUp - 1);
		other.begin();
		helped_ = !helped_;
		trying_ = true;
		rounds_ = 0;
	}

	void choose()
	{
		if (way_[!helped_].rounds == 0) return tryOther();
		const Way &other = way_[helped_], &taken = way_[!helped_];
		if (other.heldUp * other.least >= taken.mean()) helped_ = !helped_;
		way_[helped_].begin();
		trying_ = false;
		rounds_ = 0;
	}

	Way  way_[2]; // alone, helped
	bool helped_ = true, trying_ = true;
	int  rounds_ = 0;
};

} // namespace rcr

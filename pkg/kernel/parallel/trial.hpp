// Whether help makes a loop faster: its times with helpers and alone are measured, and the faster way is taken.
//
// A helper is of no use where its core has other work, or where what it touches has to travel between caches for longer than it
// saves. No size of a loop tells that. Results do not depend on the way.
#pragma once

#include <algorithm>
#include <limits>

namespace rcr {

class Trial {
public:
	/// Whether the next round is to be helped: in turn at first, then as was faster, and now and then the other way.
	bool helped() const
	{
		if (rounds_ < firstRounds) return rounds_ % 2 == 0;
		const bool faster = least_[true] < least_[false];
		return rounds_ % interval == 0 ? !faster : faster;
	}

	/// Books a round and the time that a unit of its work took. Older times count less, so that the trial follows what else the machine does.
	void book(bool helped, double time)
	{
		least_[helped] = std::min(forgetting * least_[helped], time);
		++rounds_;
	}

private:
	static constexpr int    firstRounds = 6;
	static constexpr int    interval    = 50;   // rounds between two of the other way: where help doubles the time it costs 2 %
	static constexpr double forgetting  = 1.05; // of the least time, by which it grows with every round of its way

	double least_[2] = { std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity() }; // alone, helped
	int    rounds_   = 0;
};

} // namespace rcr

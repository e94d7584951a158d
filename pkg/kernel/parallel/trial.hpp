// Whether help makes a loop faster: its times with helpers and alone are measured, and the faster way is taken.
//
// A helper is of no use where its core has other work, or where what it touches has to travel between caches for longer than it
// saves. No size of a loop tells that. The first rounds of a way have yet to bring the data to its caches, so a way is tried for some
// rounds in a row, and the first of them do not count. Results do not depend on the way.
#pragma once

#include <algorithm>
#include <limits>

namespace rcr {

class Trial {
public:
	/// Whether the next round is to be helped: some rounds of each way at first, then as was faster, and now and then some of the other way.
	bool helped() const { return helped_; }

	/// Books a round of the present way and the time that a unit of its work took. Older times count less, so that the trial follows what else the
	/// machine does.
	void book(double time)
	{
		++rounds_;
		if (rounds_ > warmUp) least_[helped_] = std::min(forgetting * least_[helped_], time);
		const bool hopeless = rounds_ == warmUp + 1 && time > farSlower * least_[!helped_];
		if (trying_ ? hopeless || rounds_ == tried : rounds_ == interval) changeWay();
	}

private:
	static constexpr double infinity   = std::numeric_limits<double>::infinity();
	static constexpr int    warmUp     = 2;    // rounds
	static constexpr int    tried      = 8;    // rounds of a way on trial …
	static constexpr int    interval   = 400;  // … and of the faster one in between: where help doubles the time trials cost 2 %
	static constexpr double farSlower  = 2;    // than the other way: no more rounds are needed to know it
	static constexpr double forgetting = 1.05; // of the least time, by which it grows with every round

	void changeWay()
	{
		trying_ = !trying_;
		rounds_ = 0;
		helped_ = trying_ ? !helped_ : least_[true] < least_[false];
		if (trying_) least_[helped_] = infinity; // as it was before is not known any more
	}

	double least_[2] = { infinity, infinity }; // alone, helped
	bool   helped_ = true, trying_ = false;
	int    rounds_ = interval - tried; // at first the other way is tried soon
};

} // namespace rcr

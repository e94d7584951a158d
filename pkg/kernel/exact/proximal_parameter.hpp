// The stiffness ρ of proximal steps (proximal_problem.hpp), from step to step.
#pragma once

#include <algorithm>

namespace rcr {

/// ρ rises while steps arrive and falls where one does not. A failure also doubles the number of steps that must arrive
/// before the next rise: the solution then runs away from an unstable state, and that takes time.
class Stiffness {
public:
	struct Limits {
		double start, least, most; // ρ [-]
		double rise, fall;         // factors of a change
		int    maxPatience;        // steps at one ρ, at most
	};

	explicit Stiffness(const Limits& limits) : limits_(limits), rho_(limits.start) { }

	double rho() const { return rho_; }

	void arrived()
	{
		if (raised_) patience_ = std::max(1, patience_ / 2);
		raised_ = ++steps_ >= patience_;
		if (!raised_) return;
		steps_ = 0;
		rho_   = std::min(limits_.most, limits_.rise * rho_);
	}

	void failed()
	{
		patience_ = std::min(limits_.maxPatience, 2 * patience_);
		steps_    = 0;
		raised_   = false;
		rho_      = std::max(limits_.least, rho_ / limits_.fall);
	}

private:
	Limits limits_;
	double rho_;
	int    patience_ = 1;     // steps that must arrive before the next rise
	int    steps_    = 0;     // that have arrived since the last change
	bool   raised_   = false; // by the last step
};

} // namespace rcr

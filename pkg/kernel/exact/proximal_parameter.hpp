// The parameter ρ of proximal steps (proximal_problem.hpp) from step to step.
#pragma once

#include <algorithm>

namespace rcr {

/// ρ rises while steps converge and falls when one does not. Each failure also doubles the number
/// of steps that must converge before the next rise. A converged step after a rise halves it. The
/// solution takes several steps to leave an unstable state.
class ProximalParameter {
public:
	struct Limits {
		double start, min, max; // ρ [-]
		double rise, fall;      // factors of a change
		int    maxPatience;     // steps at one ρ
	};

	explicit ProximalParameter(const Limits& limits) : limits_(limits), rho_(limits.start) { }

	double rho() const { return rho_; }

	void stepConverged()
	{
		if (raised_) patience_ = std::max(1, patience_ / 2);
		raised_ = ++steps_ >= patience_;
		if (!raised_) return;
		steps_ = 0;
		rho_   = std::min(limits_.max, limits_.rise * rho_);
	}

	void stepFailed()
	{
		patience_ = std::min(limits_.maxPatience, 2 * patience_);
		steps_    = 0;
		raised_   = false;
		rho_      = std::max(limits_.min, rho_ / limits_.fall);
	}

private:
	Limits limits_;
	double rho_;
	int    patience_ = 1;     // steps that must converge before the next rise
	int    steps_    = 0;     // converged since the last change
	bool   raised_   = false; // by the last step
};

} // namespace rcr

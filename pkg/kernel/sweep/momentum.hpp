// Nesterov momentum for Gauss–Seidel sweeps, with restart.
//
//   y = p + β (p − p_old),  β = (τ − 1)/τ⁺,  τ⁺ = (1 + √(1 + 4 τ²))/2
//   p_old ← p,  p ← sweep(y)
//   τ ← 1 (restart) if ‖p − y‖² > (1 + growth) · its minimum since the last restart, else τ⁺
//
// ‖p − y‖² is the error of y, which the sweep corrects. Unlike ‖p − p_old‖², it does not grow
// with β.
// Source: Nesterov 1983; O'Donoghue and Candès 2015 (restart); Mazhar et al. 2015 (momentum in
// contact dynamics).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace rcr {

/// τ and its restart. Some growth of the error is allowed, because waves due to momentum decay. The
/// allowed growth shrinks if a run does not lower the minimum, since restarts would cycle.
class Momentum {
public:
	double beta() const { return (tau_ - 1) / next(); }
	/// `error`: ‖p − y‖² of the last sweep.
	void advance(double error)
	{
		if (error <= (1 + growth_) * least_) {
			tau_   = next();
			least_ = std::min(least_, error);
			return;
		}
		growth_    = least_ < lastLeast_ ? std::min(1.2 * growth_, maxGrowth)
		                                 : std::max(0.5 * growth_, minGrowth);
		lastLeast_ = least_;
		least_     = error;
		tau_       = 1;
	}

private:
	// measured on packings of 500 and 2000 grains: 2 always converges, 3 may stall at 1e-4
	static constexpr double maxGrowth = 2, minGrowth = 0.05;

	double next() const { return (1 + std::sqrt(1 + 4 * tau_ * tau_)) / 2; }

	double tau_ = 1, growth_ = maxGrowth;
	// minimum of the error in this run and in the last
	double least_ = std::numeric_limits<double>::infinity(), lastLeast_ = least_;
};

} // namespace rcr

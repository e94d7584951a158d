// Nesterov momentum for Gauss–Seidel sweeps, and when to restart it.
//
//   y = p + β (p − p_old),  β = (τ − 1)/τ⁺,  τ⁺ = (1 + √(1 + 4 τ²))/2
//   p_old ← p,  p ← sweep(y)
//   τ ← 1 where the error of y has grown too far above its least value since the last restart, else τ⁺
//
// The error is ‖p − y‖², what the sweep had to correct: unlike ‖p − p_old‖² it does not grow with β itself.
// Source: Nesterov 1983; O'Donoghue and Candès 2015 (restart); Mazhar et al. 2015 (momentum in contact dynamics).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace rcr {

/// τ and when to take it back to 1. A wave that momentum sets up comes down again by itself, so some growth is left
/// to pass; where runs end no lower than the one before, it would cycle for ever, and less is left.
class Momentum {
public:
	double beta() const { return (tau_ - 1) / next(); }
	void   advance(double error)
	{
		if (error <= (1 + growth_) * least_) {
			tau_   = next();
			least_ = std::min(least_, error);
			return;
		}
		growth_    = least_ < lastLeast_ ? std::min(1.2 * growth_, maxGrowth) : std::max(0.5 * growth_, minGrowth);
		lastLeast_ = least_;
		least_     = error;
		tau_       = 1;
	}

private:
	// measured on packings of 500 and 2000 particles, cold and warm: 3 converges everywhere, 4 may stall at 1e-4
	static constexpr double maxGrowth = 2, minGrowth = 0.05;

	double next() const { return (1 + std::sqrt(1 + 4 * tau_ * tau_)) / 2; }

	double tau_ = 1, growth_ = maxGrowth;
	double least_ = std::numeric_limits<double>::infinity(), lastLeast_ = least_; // of the error, in this run and the last
};

} // namespace rcr

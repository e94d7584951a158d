// The parameter ρ of proximal steps (proximal_problem.hpp) from step to step.
#pragma once

#include <algorithm>

namespace rcr {

/// ρ rises while steps converge and falls when one does not. Each failure also doubles the number
/// of steps that must converge before the next rise. A step that converges right after a rise
/// halves this number. The solution takes several steps to leave an unstable state.
class ProximalParameter {
public:
	/// `most`: bound of ρ. Rounding dominates above; a row of a thousand bodies needs 1e7.
	explicit ProximalParameter(double most = leastBound)
	        : most_(std::clamp(most, leastBound, largestBound))
	{
	}
	double rho() const { return rho_; }

	void stepConverged()
	{
		if (raised_) patience_ = std::max(1, patience_ / 2);
		raised_ = ++steps_ >= patience_;
		if (!raised_) return;
		steps_ = 0;
		rho_   = std::min(most_, change * rho_);
	}

	void stepFailed()
	{
		patience_ = std::min(maxPatience, 2 * patience_);
		steps_    = 0;
		raised_   = false;
		rho_      = std::max(min, rho_ / change);
	}

private:
	static constexpr double min = 1e-2, leastBound = 1e6, largestBound = 1e8;
	static constexpr double change      = 10;      // factor of a rise or fall
	static constexpr int    maxPatience = 64;      // steps at one ρ

	double most_;
	double rho_      = 1e3;
	int    patience_ = 1;     // steps that must converge before the next rise
	int    steps_    = 0;     // converged since the last change
	bool   raised_   = false; // by the last step
};

} // namespace rcr

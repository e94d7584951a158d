// A jam: bodies whose motion is prescribed ask for more than rigid grains allow.
//
// Then no velocities satisfy u_n + b_n ≥ 0, the iterations end somewhere, and the grains sink into each other step by step. It is
// told from a solver that only was stopped early by what happens: the deepest overlap is beyond what any scene of grains at rest
// or in flow has shown (5e-3 of R₁ + R₂), it grows step after step, and no step converges.
#pragma once

#include <core/Body.hpp>

#include "../kernel/problem/contact_problem.hpp"

namespace yade {

class JamGuard {
public:
	static constexpr double crushed  = 0.02; // overlap over R₁ + R₂
	static constexpr int    patience = 10;   // steps of growth

	/// After a step that did not converge: its deepest overlap over R₁ + R₂, at this point of the problem. Throws std::runtime_error.
	void failed(double overlap, std::size_t point, const rcr::ContactProblem&);
	/// After a step that converged.
	void forget() { grown_ = 0, last_ = 0; }

private:
	int    grown_ = 0; // steps for which the overlap has grown
	double last_  = 0;
};

} // namespace yade

// Grains that are squeezed on and on by bodies whose motion is prescribed.
//
// Rigid grains do not give way. Contacts that yield (solve_yielding.cpp) let the drive have its will step by step, so the one sign of a squeeze
// is the deepest overlap: beyond what scenes at rest or in flow show (5e-3 of R₁ + R₂), and growing. It may pause or recede a
// little while grains rearrange, and steps may converge meanwhile: neither is an end of it. Only an overlap that has been taken back is.
#pragma once

#include <vector>

#include "problem/contact_problem.hpp"

namespace rcr {

class Squeeze {
public:
	static constexpr double crushed  = 0.02; // overlap over R₁ + R₂ where a squeeze begins
	static constexpr int    patience = 10;   // steps in which it grows deeper than ever before it is told

	// Plain numbers, to be saved with the scene: the message then comes in the same step after a reload.
	int    grown     = 0; // steps of growth in the present squeeze
	int    certified = 0; // steps of the present squeeze that had no solution
	double deepest   = 0; // its deepest overlap so far, over R₁ + R₂

	enum class Verdict { none, jam, notConverged };

	/// Takes the deepest overlap of a step over R₁ + R₂ (0: none), and whether the step had no solution. After `patience` steps
	/// of growth, and again after as many more, the verdict is a jam if one of the steps had no solution.
	Verdict update(double overlap, bool noSolution)
	{
		if (!(overlap > crushed)) {
			*this = {};
			return Verdict::none;
		}
		certified += noSolution;
		if (overlap <= deepest) return Verdict::none;
		deepest = overlap;
		if (++grown < patience) return Verdict::none;
		grown = 0;
		return certified > 0 ? Verdict::jam : Verdict::notConverged;
	}

	/// Grains are squeezed at present.
	bool active() const { return deepest > 0; }
};

/// Bodies that a prescribed velocity moves, in order: who squeezes. None: loads can be carried, the solver needs more iterations.
std::vector<int> drivenBodies(const ContactProblem&);

} // namespace rcr

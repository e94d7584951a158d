// Steps that missed the tolerance of the solver: how many, and whether they did harm.
//
// A missed step is harmless while the overlaps that it leaves are taken back: those of beds at rest and in flow stay below 5e-3 of R₁ + R₂. It is told
// once, and again each time things get worse: overlaps twice as deep as those told of, or ten times as many steps without a solution.
//
// Overlaps that grow although no step misses are those of something that the steps do not see: forces added after the solve, bodies that are put
// elsewhere. They are told beyond 2e-2 of R₁ + R₂, and twice those of the first step, with which the scene began.
#pragma once

#include <string>

namespace rcr {

class MissedSteps {
public:
	static constexpr double harmless = 5e-3; // overlap over R₁ + R₂ …
	static constexpr double deep     = 2e-2; // … and one that no solution leaves: such a step has missed, whatever its residual

	// Plain numbers, to be saved with the scene.
	long   steps   = 0; // all
	long   missed  = 0; // that ended beyond the tolerance, or with a deep overlap
	long   yielded = 0; // of these, without a solution: their contacts have yielded
	double deepest = 0; // overlap over R₁ + R₂, of all steps but those that have taken it back

	long   toldMissed = 0, toldYielded = 0; // of the last message
	double toldDeepest = 0;

	/// After each step: whether it missed the tolerance, whether it had no solution, its deepest overlap over R₁ + R₂, and whether it has taken
	/// back what lay before it, so that overlaps are its own. True when there is something to tell.
	bool count(bool missed, bool yielded, double overlap, bool takenBack = false);

	double share() const { return steps > 0 ? double(missed) / double(steps) : 0; } // of missed steps

	/// What to tell: numbers, whether they are harmless, and what to do where they are not.
	std::string message() const;
};

} // namespace rcr

// Counts steps that did not converge and decides when a warning is due.
//
// Overlaps of beds at rest and in flow stay below 5e-3 (R₁ + R₂), and the position correction
// removes them. Steps that did not converge are therefore counted silently up to that depth. A
// warning is due when the deepest overlap exceeds it and has doubled since the last warning, or
// when steps without a solution have become ten times as many.
//
// Overlaps may grow although all steps converge, if a script moves bodies or adds forces after the
// solve. The same rule applies then. The overlap of the first step needs no warning, since the
// scene began with it.
#pragma once

#include <string>

namespace rcr {

class MissedSteps {
public:
	// overlap over R₁ + R₂ from which on warnings are due
	static constexpr double reportedOverlap = 5e-3;
	// a step that ends with a deeper overlap did not converge
	static constexpr double deep            = 2e-2;

	// Plain numbers, saved with the scene.
	long   steps         = 0; // all steps
	long   missed        = 0; // steps that did not converge
	long   yielded       = 0; // steps without a solution; `missed` includes them at a tolerance > 0
	// deepest overlap over R₁ + R₂; overlaps that an overdamped step removes do not count
	double deepest       = 0;
	long   warnedYielded = 0; // steps without a solution at the last warning
	double warnedDepth   = 0; // deepest overlap at the last warning

	/// Counts a step; returns true if a warning is due. `overlap`: its deepest overlap over R₁ +
	/// R₂; `removesOverlaps`: the step is overdamped, so overlaps of its beginning are not its own.
	bool count(bool hasMissed, bool hasYielded, double overlap, bool removesOverlaps = false);

	/// The warning: finding, effect on results, remedy.
	std::string message() const;
};

} // namespace rcr

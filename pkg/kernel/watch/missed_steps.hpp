// Counts the steps that have not converged and decides when a warning is due.
//
// The position correction takes back the overlaps that a step leaves. Overlaps of beds at rest and in flow stay below 5e-3 (R₁ + R₂), so
// steps that have not converged are counted in silence up to that. A warning is due when the deepest overlap exceeds 5e-3 and has doubled
// since the last warning, and when steps without a solution are ten times as many as at the last warning.
//
// Overlaps can grow although all steps converge, by forces added after the solve or by bodies that a script moves. The same rule
// applies; the overlap of the first step, with which the scene began, counts as warned of.
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

	long   toldYielded = 0; // steps without a solution, at the last warning
	double toldDeepest = 0;

	/// After each step: whether it missed the tolerance, whether it had no solution, its deepest overlap over R₁ + R₂, and whether it has taken
	/// back what lay before it, so that overlaps are its own. True when there is something to tell.
	bool count(bool missed, bool yielded, double overlap, bool takenBack = false);

	double share() const { return steps > 0 ? double(missed) / double(steps) : 0; } // of missed steps

	/// What to tell: numbers, whether they are harmless, and what to do where they are not.
	std::string message() const;
};

} // namespace rcr

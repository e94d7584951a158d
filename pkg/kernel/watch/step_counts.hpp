// Counts steps, by their outcome, and decides when a warning is due.
//
// A missed step is one that did not converge, at a tolerance > 0. Overlaps of beds at rest and in
// flow stay below 5e-3 (R₁ + R₂), and the position correction removes them. Missed steps are
// therefore counted silently up to that depth. A warning is due when the deepest overlap exceeds it
// and has doubled since the last warning. It is also due at the first yielded step, and when the
// number of yielded steps has grown tenfold since the last warning. Steps in which bodies intrude on
// their paths (detection/large_displacements.hpp) warn by the same rule as yielded ones.
//
// Overlaps may grow although all steps converge, if a script moves bodies or adds forces after the
// solve. The same rule applies then. The overlap of the first step needs no warning, since the
// scene began with it.
#pragma once

#include <string>

namespace rcr {

class StepCounts {
public:
	static constexpr double reportedOverlap = 5e-3; // least overlap of a warning, over R₁ + R₂

	// Plain numbers, saved with the scene.
	long   steps         = 0; // all steps
	long   missed        = 0; // steps that did not converge, at a tolerance > 0
	long   yielded       = 0; // steps in which contacts yielded
	long   intruded      = 0; // steps in which bodies intruded on their paths
	// deepest overlap over R₁ + R₂, without overlaps that overdamped steps remove
	double deepest       = 0;
	long   warnedYielded = 0; // yielded steps at the last warning
	long   warnedIntruded = 0; // intruded steps at the last warning
	double warnedDepth   = 0; // deepest overlap at the last warning

	/// Counts a step. Returns true if a warning is due. `overlap`: its deepest overlap over R₁ +
	/// R₂. `removesOverlaps`: the step is overdamped and removes the overlaps of its beginning.
	/// `hasIntruded`: bodies intruded on their paths.
	bool count(bool hasMissed, bool hasYielded, double overlap, bool removesOverlaps,
	        bool hasIntruded);

	/// The warning: finding, effect on results, remedy.
	std::string message() const;
};

} // namespace rcr

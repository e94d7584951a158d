// Detects that driven bodies squeeze grains without end.
//
// Rigid grains do not give way, but yielding contacts (solve_yielding.cpp) let the drive continue.
// The sign of a squeeze is then an overlap beyond 0.02 (R₁ + R₂) that keeps growing. Pauses and
// small recessions do not end a squeeze, since grains rearrange.
#pragma once

namespace rcr {

class JamDetector {
public:
	static constexpr double crushed  = 0.02; // overlap over R₁ + R₂ at which a squeeze begins
	// least growth of that overlap that counts; the solver's tolerance may cause less
	static constexpr double growth   = 1e-4;
	static constexpr int    patience = 10;   // steps of growth up to a verdict

	// Plain numbers, saved with the scene.
	int    grown      = 0; // steps in which the overlap of this squeeze exceeded `deepest` so
	int    unsolvable = 0; // steps of this squeeze that had no solution
	double deepest    = 0; // overlap at the last of these steps, over R₁ + R₂

	enum class Verdict { none, jam, notConverged };

	/// Adds a step with its deepest overlap over R₁ + R₂ (0: none). After every `patience` steps of
	/// growth the verdict is `jam` if a step had no solution, else `notConverged`.
	Verdict update(double overlap, bool noSolution)
	{
		if (!(overlap > crushed)) {
			*this = {};
			return Verdict::none;
		}
		unsolvable += noSolution;
		if (overlap <= deepest + growth) return Verdict::none;
		deepest = overlap;
		if (++grown < patience) return Verdict::none;
		grown = 0;
		return unsolvable > 0 ? Verdict::jam : Verdict::notConverged;
	}

	/// Grains are squeezed at present.
	bool active() const { return deepest > 0; }
};

} // namespace rcr

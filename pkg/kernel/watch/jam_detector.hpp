// Detects that driven bodies squeeze grains without end.
//
// Rigid grains do not give way, but yielding contacts (solve_yielding.cpp) let the drive continue.
// A squeeze shows as an overlap beyond 0.02 (R₁ + R₂) that keeps growing. Pauses and small
// recessions do not end a squeeze, since grains rearrange.
#pragma once

namespace rcr {

class JamDetector {
public:
	// overlap over R₁ + R₂ at which a squeeze begins; a step that ends deeper has not converged
	static constexpr double jamOverlap = 0.02;
	static constexpr double growth   = 1e-4; // least growth of that overlap; tolerances cause less
	static constexpr int    patience = 10;   // new maxima up to a verdict

	// Plain numbers, saved with the scene.
	int    newMaxima = 0; // new maxima of the overlap since the last verdict
	int    yielded   = 0; // steps of this squeeze in which contacts yielded
	double deepest   = 0; // maximum of the overlap in this squeeze, over R₁ + R₂

	enum class Verdict { none, jam, notConverged };

	/// Adds a step with its deepest overlap over R₁ + R₂ (0: none). After every `patience` new
	/// maxima, the verdict is `jam` if contacts have yielded, else `notConverged`.
	Verdict update(double overlap, bool hasYielded)
	{
		if (!(overlap > jamOverlap)) {
			*this = {};
			return Verdict::none;
		}
		yielded += hasYielded;
		if (overlap <= deepest + growth) return Verdict::none;
		deepest = overlap;
		if (++newMaxima < patience) return Verdict::none;
		newMaxima = 0;
		return yielded > 0 ? Verdict::jam : Verdict::notConverged;
	}

	/// Returns true while grains are squeezed.
	bool active() const { return deepest > 0; }
};

} // namespace rcr

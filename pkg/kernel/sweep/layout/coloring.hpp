// Independent batches: pairs of one colour share no free body, so they may be solved in any order or at once.
#pragma once

#include <cstdint>
#include <vector>

namespace rcr {

/// Greedy colouring: each pair takes the lowest colour that is free at both of its bodies. Dense packings of particles
/// need 7 to 9 colours.
class Coloring {
public:
	static constexpr int colors = 16; // a pair that finds none is left to the caller: a body with many contacts
	static constexpr int none   = -1;

	void reset(std::size_t bodies) { used_.assign(bodies, 0); }

	/// Takes all colours from a body: pairs swept at another time do not matter.
	void free(int body) { used_[body] = 0; }

	/// `limits1`, `limits2`: whether that body keeps its pairs apart; a prescribed one does not, nothing moves it.
	int take(int body1, bool limits1, int body2, bool limits2)
	{
		const std::uint32_t free = ~(used_[body1] | used_[body2]), lowest = free & (~free + 1);
		if (lowest >> colors) return none;
		if (limits1) used_[body1] |= lowest;
		if (limits2) used_[body2] |= lowest;
		return __builtin_ctz(lowest);
	}

private:
	std::vector<std::uint32_t> used_; // a body: bit c = colour c is taken
};

} // namespace rcr

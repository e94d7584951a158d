// Independent batches: pairs of one colour share no free body, so they may be solved in any order or at once.
#pragma once

#include <cstdint>
#include <vector>

namespace rcr {

/// Greedy colouring that pairs may join and leave: each takes the lowest colour that is free at both of its bodies.
/// Dense packings of particles need 7 to 9 colours.
class Coloring {
public:
	static constexpr int colors = 16; // a pair that finds none is left to the caller: a body with many contacts
	static constexpr int none   = -1;

	/// `limits[body]` says whether a body keeps its pairs apart; a prescribed one does not, nothing moves it.
	explicit Coloring(std::vector<bool> limits = {}) : limits_(std::move(limits)), used_(limits_.size()) { }

	int take(int body1, int body2)
	{
		const std::uint32_t used = used_[body1] | used_[body2];
		for (int color = 0; color < colors; ++color) {
			if (used >> color & 1u) continue;
			mark(body1, color);
			mark(body2, color);
			return color;
		}
		return none;
	}

	void release(int body1, int body2, int color)
	{
		used_[body1] &= ~(1u << color);
		used_[body2] &= ~(1u << color);
	}

private:
	void mark(int body, int color)
	{
		if (limits_[body]) used_[body] |= 1u << color;
	}

	std::vector<bool>          limits_;
	std::vector<std::uint32_t> used_; // a body: bit c = colour c is taken
};

} // namespace rcr

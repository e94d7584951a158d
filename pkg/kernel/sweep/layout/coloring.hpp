// Greedy graph colouring: pairs of one colour share no free body, so lanes can solve them at once.
#pragma once

#include <cstdint>
#include <vector>

namespace rcr {

constexpr std::int32_t none = -1; // no colour, slot, partition, section or island

/// Each pair takes the lowest colour that is free at both bodies. Dense packings need 7 to 9.
class Coloring {
public:
	static constexpr int colors = 16;

	explicit Coloring(std::size_t bodies = 0) : used_(bodies) { }

	/// Frees all colours of a body, for pairs that are swept at another time.
	void free(int body) { used_[body] = 0; }

	/// Returns the colour of a pair; none if all are taken at a body. `moves1`, `moves2`: false for
	/// a prescribed body, which pairs of one colour may share.
	int take(int body1, bool moves1, int body2, bool moves2)
	{
		const std::uint32_t free = ~(used_[body1] | used_[body2]), lowest = free & (~free + 1);
		if (lowest >> colors) return none;
		if (moves1) used_[body1] |= lowest;
		if (moves2) used_[body2] |= lowest;
		return __builtin_ctz(lowest);
	}

private:
	std::vector<std::uint32_t> used_; // bit c of a body: colour c is taken
};

} // namespace rcr

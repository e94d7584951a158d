// Slabs of an island: runs of levels of a breadth-first walk over its bodies.
//
// A pair joins bodies of one level or of two successive ones. A slab has two levels at least, so a pair lies within a slab or joins
// it to the next one, and no body takes part in two joints: all slabs may be swept at once, and then all joints.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace rcr {

class Slabs {
public:
	static constexpr std::int32_t none = -1;
	using Edge                         = std::array<std::int32_t, 2>; // two bodies

	void reset(std::size_t bodies);

	/// Cuts the island of these edges into about `count` slabs of as many pairs, numbered from `first`; returns how many there are. Bodies
	/// of different calls are distinct.
	int cut(const std::vector<Edge>& edges, int count, int first);

	/// The slab of a body; none where no edge has it.
	std::int32_t of(int body) const { return slab_[body]; }

private:
	void connect(const std::vector<Edge>&);
	void walkAll();
	void walk(std::int32_t root, char pass);

	std::vector<std::int32_t> slab_, local_;     // a body: its slab, its number in the island
	std::vector<std::int32_t> body_;             // of a number in the island, as are the next three
	std::vector<std::int32_t> begin_, neighbor_; // its neighbours, and the end
	std::vector<Edge>         renumbered_;       // of the island, by these numbers
	std::vector<char>         pass_;             // the last walk that came by
	std::vector<std::int32_t> order_;            // of the walk, and room for one more
	std::int32_t              ordered_ = 0;      // how many of these there are
	std::vector<std::int32_t> level_;            // where the levels of the walk begin
};

} // namespace rcr

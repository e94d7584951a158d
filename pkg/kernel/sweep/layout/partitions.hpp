// Partitions of an island: runs of levels of a breadth-first search over its bodies.
//
// A pair joins bodies of one level or of two successive levels. A partition has at least two
// levels; the last one may have one. So a pair lies within a partition or on the interface to the
// next one, and no body has pairs on two interfaces. All partitions may be swept at once, and then
// all interfaces.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sweep/layout/coloring.hpp"

namespace rcr {

class Partitions {
public:
	using Edge = std::array<std::int32_t, 2>; // two bodies

	void reset(std::size_t bodies);

	/// Cuts the island of these edges into about `count` partitions with equal numbers of pairs.
	/// Numbers them from `first` and returns how many there are. Islands must not share bodies.
	int cut(const std::vector<Edge>& edges, int count, int first);

	/// Number of levels of an island that is not cut.
	int measure(const std::vector<Edge>& edges);
	/// Number of levels of the last island.
	int levels() const { return int(level_.size()); }

	/// The partition of a body; none if the body has no edge.
	std::int32_t of(int body) const { return partition_[body]; }

private:
	void connect(const std::vector<Edge>&);
	void searchAll();
	void search(std::int32_t root, char pass);

	// of each body
	std::vector<std::int32_t> partition_, local_; // local_: its number in the island

	// of each number in the island
	std::vector<std::int32_t> body_;
	std::vector<std::int32_t> begin_,
	        neighbor_;       // neighbor_[begin_[i]] … neighbor_[begin_[i + 1] − 1]
	std::vector<char> pass_; // the last search that reached it

	std::vector<Edge>         renumbered_; // edges of the island in these numbers
	std::vector<std::int32_t> order_;      // of the search, and one spare place
	std::int32_t              ordered_ = 0;
	std::vector<std::int32_t> level_; // first places of the levels in order_
};

} // namespace rcr

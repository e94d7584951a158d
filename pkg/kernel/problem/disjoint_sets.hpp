// Disjoint sets of bodies: union-find with path halving.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace rcr {

class DisjointSets {
public:
	explicit DisjointSets(std::size_t bodies) : parent_(bodies)
	{
		std::iota(parent_.begin(), parent_.end(), 0);
	}

	void join(int body1, int body2) { parent_[find(body1)] = find(body2); }

	/// The body that represents the set of this body.
	int find(int body)
	{
		while (parent_[body] != body)
			body = parent_[body] = parent_[parent_[body]];
		return body;
	}

private:
	std::vector<int> parent_;
};

} // namespace rcr

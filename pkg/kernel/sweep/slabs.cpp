#include "sweep/slabs.hpp"

namespace rcr {

void Slabs::reset(std::size_t bodies)
{
	slab_.assign(bodies, none);
	local_.resize(bodies);
}

/// Numbers the bodies of the island and lists the neighbours of each.
void Slabs::connect(const std::vector<Edge>& edges)
{
	body_.clear();
	begin_.assign(1, 0);
	for (const Edge& edge : edges)
		for (const std::int32_t body : edge) {
			if (slab_[body] == none) {
				slab_[body]  = 0;
				local_[body] = int(body_.size());
				body_.push_back(body);
				begin_.push_back(0);
			}
			++begin_[local_[body] + 1];
		}
	for (std::size_t k = 1; k < begin_.size(); ++k)
		begin_[k] += begin_[k - 1];
	neighbor_.resize(2 * edges.size());
	for (auto edge = edges.rbegin(); edge != edges.rend(); ++edge) // backwards, begin_ being the end of each list until then
		for (int side : { 0, 1 })
			neighbor_[--begin_[local_[(*edge)[side]] + 1]] = local_[(*edge)[1 - side]];
	begin_.erase(begin_.begin());
	begin_.push_back(int(neighbor_.size()));
}

/// Adds what can be reached from the root to the order, level after level.
void Slabs::walk(std::int32_t root, int pass)
{
	std::size_t next = order_.size();
	order_.push_back(root);
	pass_[root] = pass;
	while (next < order_.size()) {
		level_.push_back(next);
		for (const std::size_t end = order_.size(); next < end; ++next)
			for (int k = begin_[order_[next]]; k < begin_[order_[next] + 1]; ++k)
				if (pass_[neighbor_[k]] != pass) {
					pass_[neighbor_[k]] = pass;
					order_.push_back(neighbor_[k]);
				}
	}
}

/// Walks from the far end of a first walk: the levels are then short and many. Parts that only overflow connects come one after the other.
void Slabs::walkAll()
{
	pass_.assign(body_.size(), 0);
	order_.clear();
	level_.clear();
	for (std::size_t root = 0; root < body_.size(); ++root) {
		if (pass_[root] != 0) continue;
		const std::size_t done = order_.size(), levels = level_.size();
		walk(int(root), 1);
		const std::int32_t far = order_.back();
		order_.resize(done);
		level_.resize(levels);
		walk(far, 2);
	}
}

int Slabs::cut(const std::vector<Edge>& edges, int count, int first)
{
	constexpr int leastLevels = 2;
	connect(edges);
	walkAll();
	int         slabs = 1, levels = 0;
	std::size_t seen = 0; // ends of edges
	for (std::size_t k = 0; k < level_.size(); ++k, ++levels) {
		if (levels >= leastLevels && seen * count >= neighbor_.size() * slabs) {
			++slabs;
			levels = 0;
		}
		for (std::size_t i = level_[k]; i < (k + 1 < level_.size() ? level_[k + 1] : order_.size()); ++i) {
			slab_[body_[order_[i]]] = first + slabs - 1;
			seen += begin_[order_[i] + 1] - begin_[order_[i]];
		}
	}
	return slabs;
}

} // namespace rcr

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

/// Adds what can be reached from the root to the order, level after level. Each neighbour is written, and stays where it is new: a branch on that
/// would be mispredicted as often as not.
void Slabs::walk(std::int32_t root, char pass)
{
	std::int32_t next = ordered_;
	order_[ordered_++] = root;
	pass_[root]        = pass;
	while (next < ordered_) {
		level_.push_back(next);
		for (const std::int32_t end = ordered_; next < end; ++next)
			for (std::int32_t k = begin_[order_[next]]; k < begin_[order_[next] + 1]; ++k) {
				const std::int32_t neighbor = neighbor_[k];
				order_[ordered_]            = neighbor;
				ordered_ += pass_[neighbor] != pass;
				pass_[neighbor] = pass;
			}
	}
}

/// Walks from the far end of a first walk: the levels are then short and many. Parts that only overflow connects come one after the other.
void Slabs::walkAll()
{
	pass_.assign(body_.size(), 0);
	order_.resize(body_.size() + 1);
	ordered_ = 0;
	level_.clear();
	for (std::size_t root = 0; root < body_.size(); ++root) {
		if (pass_[root] != 0) continue;
		const std::int32_t done   = ordered_;
		const std::size_t  levels = level_.size();
		walk(std::int32_t(root), 1);
		const std::int32_t far = order_[ordered_ - 1];
		ordered_               = done;
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
		for (std::int32_t i = level_[k]; i < (k + 1 < level_.size() ? level_[k + 1] : ordered_); ++i) {
			slab_[body_[order_[i]]] = first + slabs - 1;
			seen += begin_[order_[i] + 1] - begin_[order_[i]];
		}
	}
	return slabs;
}

} // namespace rcr

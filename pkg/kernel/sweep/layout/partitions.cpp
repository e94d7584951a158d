#include "sweep/layout/partitions.hpp"

#include "problem/list_by_key.hpp"

namespace rcr {

void Partitions::reset(std::size_t bodies)
{
	partition_.assign(bodies, none);
	local_.resize(bodies);
}

/// Numbers the bodies of the island and lists the neighbours of each.
void Partitions::connect(const std::vector<Edge>& edges)
{
	body_.clear();
	renumbered_ = edges;
	for (Edge& edge : renumbered_)
		for (std::int32_t& body : edge) {
			if (partition_[body] == none) {
				partition_[body] = 0;
				local_[body]     = int(body_.size());
				body_.push_back(body);
			}
			body = local_[body];
		}
	listByKey(body_.size(), begin_, neighbor_, [&](auto add) {
		for (const Edge& edge : renumbered_)
			add(edge[0], edge[1]), add(edge[1], edge[0]);
	});
}

/// Adds all bodies connected with the root to the order, level after level. Writes each neighbour
/// and keeps it if it is new: a branch would be mispredicted half of the time.
void Partitions::search(std::int32_t root, char pass)
{
	const std::int32_t *const begin = begin_.data(), *const neighbors = neighbor_.data();
	std::int32_t* const order   = order_.data();
	char* const         reached = pass_.data();
	std::int32_t        next = ordered_, ordered = ordered_ + 1;
	order[next]   = root;
	reached[root] = pass;
	while (next < ordered) {
		level_.push_back(next);
		for (const std::int32_t end = ordered; next < end; ++next) {
			const std::int32_t body = order[next], last = begin[body + 1];
			for (std::int32_t k = begin[body]; k < last; ++k) {
				const std::int32_t neighbor = neighbors[k];
				order[ordered]              = neighbor;
				ordered += reached[neighbor] != pass;
				reached[neighbor] = pass;
			}
		}
	}
	ordered_ = ordered;
}

/// Searches from the last body of a first search: its levels are short and many. Parts that only
/// the overflow connects follow each other.
void Partitions::searchAll()
{
	pass_.assign(body_.size(), 0);
	order_.resize(body_.size() + 1);
	ordered_ = 0;
	level_.clear();
	for (std::size_t root = 0; root < body_.size(); ++root) {
		if (pass_[root] != 0) continue;
		const std::int32_t done   = ordered_;
		const std::size_t  levels = level_.size();
		search(std::int32_t(root), 1);
		const std::int32_t far = order_[ordered_ - 1];
		ordered_               = done;
		level_.resize(levels);
		search(far, 2);
	}
}

int Partitions::measure(const std::vector<Edge>& edges)
{
	connect(edges);
	searchAll();
	for (const std::int32_t body : body_)
		partition_[body] = none;
	return levels();
}

int Partitions::cut(const std::vector<Edge>& edges, int count, int first)
{
	constexpr int minLevels = 2;
	connect(edges);
	searchAll();
	int         partitions = 1, levels = 0;
	std::size_t seen = 0; // edge ends so far
	for (std::size_t k = 0; k < level_.size(); ++k, ++levels) {
		if (levels >= minLevels && seen * count >= neighbor_.size() * partitions) {
			++partitions;
			levels = 0;
		}
		for (std::int32_t i = level_[k]; i < (k + 1 < level_.size() ? level_[k + 1] : ordered_);
		        ++i) {
			partition_[body_[order_[i]]] = first + partitions - 1;
			seen += begin_[order_[i] + 1] - begin_[order_[i]];
		}
	}
	return partitions;
}

} // namespace rcr

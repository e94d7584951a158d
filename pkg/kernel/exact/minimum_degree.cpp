#include "exact/minimum_degree.hpp"

#include <algorithm>

namespace rcr {

namespace {

	using Nodes = std::vector<std::int32_t>;

	/// Nodes in doubly linked lists, one a degree.
	class DegreeLists {
	public:
		explicit DegreeLists(std::int32_t size)
		        : head_(size, -1)
		        , next_(size, -1)
		        , previous_(size, -1)
		        , degree_(size, -1)
		{
		}

		void insert(std::int32_t node, std::int32_t degree)
		{
			degree_[node]   = degree;
			previous_[node] = -1;
			next_[node]     = head_[degree];
			if (next_[node] >= 0) previous_[next_[node]] = node;
			head_[degree] = node;
			lowest_       = std::min(lowest_, degree);
		}

		void remove(std::int32_t node)
		{
			(previous_[node] >= 0 ? next_[previous_[node]] : head_[degree_[node]]) = next_[node];
			if (next_[node] >= 0) previous_[next_[node]] = previous_[node];
		}

		std::int32_t takeLowest()
		{
			while (head_[lowest_] < 0)
				++lowest_;
			const std::int32_t node = head_[lowest_];
			remove(node);
			return node;
		}

		std::int32_t degree(std::int32_t node) const { return degree_[node]; }

	private:
		Nodes        head_, next_, previous_, degree_;
		std::int32_t lowest_ = 0;
	};

	/// The graph after some eliminations: an eliminated node lives on as an element, the clique of its neighbours.
	struct QuotientGraph {
		std::vector<Nodes> nodes;    // a node -> neighbours that no element covers; an element -> its clique
		std::vector<Nodes> elements; // a node -> the elements it belongs to
		Nodes              mark;     // stamp of the last visit
		Nodes              outside;  // an element -> number of its nodes outside the newest clique
		Nodes              stamp;    // … valid for this pivot

		QuotientGraph(const Nodes& begin, const Nodes& neighbours)
		        : nodes(begin.size() - 1)
		        , elements(nodes.size())
		        , mark(nodes.size(), -1)
		        , outside(nodes.size(), 0)
		        , stamp(nodes.size(), -1)
		{
			for (std::size_t i = 0; i < nodes.size(); ++i)
				nodes[i].assign(neighbours.begin() + begin[i], neighbours.begin() + begin[i + 1]);
		}

		/// Turns a node into an element that absorbs the elements it belonged to; marks its clique.
		void eliminate(std::int32_t pivot)
		{
			Nodes clique;
			mark[pivot]      = pivot;
			const auto visit = [&](const Nodes& from) {
				for (std::int32_t i : from)
					if (mark[i] != pivot) {
						mark[i] = pivot;
						clique.push_back(i);
					}
			};
			visit(nodes[pivot]);
			for (std::int32_t e : elements[pivot]) {
				visit(nodes[e]);
				nodes[e].clear(); // absorbed: the new clique covers it
			}
			elements[pivot].clear();
			nodes[pivot] = std::move(clique);
		}

		/// For every other element that touches the new clique, how many of its nodes lie outside it.
		void countOutside(std::int32_t pivot)
		{
			for (std::int32_t i : nodes[pivot])
				for (std::int32_t e : elements[i]) {
					if (nodes[e].empty()) continue;
					if (stamp[e] != pivot) {
						stamp[e]   = pivot;
						outside[e] = static_cast<std::int32_t>(nodes[e].size());
					}
					--outside[e];
				}
		}

		/// Takes what the new clique covers off the lists of node i; returns the bound on its degree.
		std::int32_t prune(std::int32_t i, std::int32_t pivot)
		{
			const auto covered  = [&](std::int32_t j) { return mark[j] == pivot; };
			const auto absorbed = [&](std::int32_t e) { return nodes[e].empty() || outside[e] == 0; };
			nodes[i].erase(std::remove_if(nodes[i].begin(), nodes[i].end(), covered), nodes[i].end());
			elements[i].erase(std::remove_if(elements[i].begin(), elements[i].end(), absorbed), elements[i].end());
			std::size_t degree = nodes[i].size() + nodes[pivot].size() - 1;
			for (std::int32_t e : elements[i])
				degree += outside[e];
			elements[i].push_back(pivot);
			return static_cast<std::int32_t>(degree);
		}
	};

} // namespace

std::vector<std::int32_t> minimumDegreeOrder(const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbours)
{
	const std::int32_t size = static_cast<std::int32_t>(begin.size()) - 1;
	QuotientGraph      graph(begin, neighbours);
	DegreeLists        waiting(size);
	for (std::int32_t i = 0; i < size; ++i)
		waiting.insert(i, static_cast<std::int32_t>(graph.nodes[i].size()));
	Nodes order;
	while (static_cast<std::int32_t>(order.size()) < size) {
		const std::int32_t pivot = waiting.takeLowest();
		order.push_back(pivot);
		graph.eliminate(pivot);
		graph.countOutside(pivot);
		const std::int32_t left = size - static_cast<std::int32_t>(order.size());
		for (std::int32_t i : graph.nodes[pivot]) {
			waiting.remove(i);
			const std::int32_t grown = waiting.degree(i) + static_cast<std::int32_t>(graph.nodes[pivot].size()) - 1;
			waiting.insert(i, std::min({ graph.prune(i, pivot), grown, left - 1 }));
		}
	}
	return order;
}

} // namespace rcr

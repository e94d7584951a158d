// Islands of a layout: sets of bodies that pairs connect.
#include "problem/disjoint_sets.hpp"
#include "sweep/layout/layout.hpp"

namespace rcr {

/// Numbers the islands in the order of their first pairs.
void Layout::findIslands()
{
	DisjointSets              sets(bodyKind_.size());
	std::vector<std::int32_t> number(bodyKind_.size(), none);
	std::int32_t              whole = none; // the one island without that reduction
	for (const PackedPair& pair : pairs_)
		if (moves(pair.body1) && moves(pair.body2)) sets.join(pair.body1, pair.body2);
	island_.assign(bodyKind_.size(), none);
	islands_.clear();
	for (const PackedPair& pair : pairs_) {
		const int body = movingBodies(pair)[0];
		if (!moves(body)) continue;
		std::int32_t& island = reductions_.islands && !stretches_ ? number[sets.find(body)] : whole;
		if (island == none) {
			island = int(islands_.size());
			islands_.push_back({});
		}
		IslandShape& shape = islands_[island].shape;
		for (int one : { pair.body1, pair.body2 }) {
			if (!moves(one)) continue;
			shape.bodies += island_[one] == none;
			island_[one] = island;
		}
		const bool free = moves(pair.body1) && moves(pair.body2);
		shape.pairs += free;
		shape.bends = shape.bends || (free && pair.points > 1);
		shape.points += pair.points;
		shape.frictional = shape.frictional || pair.frictional;
		shape.diameter = shape.bodies; // of a row; `cut` measures it in larger islands
	}
}

ModelSummary Layout::summary() const
{
	ModelSummary      s;
	std::vector<bool> turns(bodyKind_.size());
	for (const PackedPair& pair : pairs_) {
		if (islandOf(pair) == none) continue;
		++s.pairs;
		s.points += pair.points;
		s.frictionalPoints += hasFriction(pair.model) ? pair.points : 0;
		if (pair.model != Model::frictionlessDisc) turns[pair.body1] = turns[pair.body2] = true;
	}
	for (std::size_t body = 0; body < bodyKind_.size(); ++body) {
		s.fixed += bodyKind_[body] == BodyKind::prescribed;
		s.bodies += island_[body] != none;
		s.rotating += island_[body] != none && turns[body];
	}
	s.islands = int(islands_.size());
	return s;
}

} // namespace rcr

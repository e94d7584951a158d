#include "layout.hpp"

#include <algorithm>

namespace rcr {

namespace {

	constexpr int chunkBlocks = 8; // 128 pairs, under a microsecond: small against a colour, large against sharing it

	BodyKind kindOf(const InverseMass& m)
	{
		if (m.x == 0 && m.y == 0 && m.rotation == 0) return BodyKind::prescribed;
		return m.x == m.y && m.x > 0 ? BodyKind::regular : BodyKind::special;
	}

} // namespace

bool Layout::update(const ContactProblem& problem)
{
	const bool sameBodies = sortBodies(problem), samePairs = findPairs(problem);
	if (sameBodies && samePairs) return false;
	color();
	makeBlocks();
	for (std::size_t k = 0; k < pairs_.size(); ++k)
		if (color_[k] != Coloring::none) place(pairs_[k], color_[k]);
	return true;
}

/// Sorts the bodies by kind; false if that differs from before.
bool Layout::sortBodies(const ContactProblem& problem)
{
	bool same = kind_.size() == problem.inverseMass.size();
	kind_.resize(problem.inverseMass.size());
	for (std::size_t i = 0; i < kind_.size(); ++i) {
		const BodyKind kind = kindOf(problem.inverseMass[i]);
		same                = same && kind == kind_[i];
		kind_[i]            = kind;
	}
	return same;
}

/// Joins neighbouring points of the same bodies, two at most; false if the pairs differ from before.
bool Layout::findPairs(const ContactProblem& problem)
{
	const std::vector<ContactPoint>& points = problem.points;
	const std::size_t                before = pairs_.size();
	std::size_t                      count  = 0;
	bool                             same   = true;
	for (std::size_t k = 0; k < points.size(); ++count) {
		const ContactPoint& c     = points[k];
		const bool          joins = k + 1 < points.size() && points[k + 1].body1 == c.body1 && points[k + 1].body2 == c.body2;
		const Pair          pair { c.body1, c.body2, std::int32_t(k), joins ? 2 : 1, Pair::outside, 0 };
		if (count == pairs_.size()) pairs_.push_back(pair);
		Pair& old = pairs_[count];
		// `firstPoint` follows from the pairs before
		if (old.body1 != pair.body1 || old.body2 != pair.body2 || old.points != pair.points) same = false;
		if (!same) old = pair;
		k += pair.points;
	}
	pairs_.resize(count);
	return same && count == before;
}

bool Layout::packable(const Pair& pair) const
{
	const BodyKind a = kind_[pair.body1], b = kind_[pair.body2];
	return (a == BodyKind::regular && b != BodyKind::special) || (b == BodyKind::regular && a != BodyKind::special);
}

/// Colours the pairs and counts them by colour and number of points.
void Layout::color()
{
	const auto limits = [this](int body) { return kind_[body] != BodyKind::prescribed; };
	coloring_.reset(kind_.size());
	color_.assign(pairs_.size(), Coloring::none);
	for (auto& ofColor : rows_)
		ofColor[0] = ofColor[1] = {};
	for (std::size_t k = 0; k < pairs_.size(); ++k) {
		Pair& pair = pairs_[k];
		pair.slot  = Pair::outside;
		if (!packable(pair)) continue;
		const int color = coloring_.take(pair.body1, limits(pair.body1), pair.body2, limits(pair.body2));
		color_[k]       = static_cast<signed char>(color);
		if (color != Coloring::none) ++row(color, pair.points).pairs;
	}
}

/// Blocks for the pairs counted, colour after colour; the slots that stay vacant are the last of each row.
void Layout::makeBlocks()
{
	chunks_.clear();
	vacantBlocks_.clear();
	pairBlocks_.clear();
	pointBlocks_ = 0;
	records_     = int(kind_.size());
	for (int color = 0; color < Coloring::colors; ++color) {
		chunkBegin_[color] = int(chunks_.size());
		for (int points : { 2, 1 }) {
			Row&      row    = this->row(color, points);
			const int first  = int(pairBlocks_.size()), blocks = (row.pairs + blockWidth - 1) / blockWidth;
			row.firstBlock   = first;
			row.nextSlot     = first * blockWidth;
			row.firstPoint   = pointBlocks_;
			for (int b = 0; b < blocks; b += chunkBlocks)
				chunks_.push_back({ first + b, std::min(chunkBlocks, blocks - b), pointBlocks_ + b * points, points });
			pairBlocks_.resize(first + blocks);
			pointBlocks_ += blocks * points;
			if (row.pairs == blocks * blockWidth) continue;
			for (int lane = row.pairs % blockWidth; lane < blockWidth; ++lane) {
				pairBlocks_.back().body1[lane] = offsetOf(ownRecord());
				pairBlocks_.back().body2[lane] = offsetOf(ownRecord());
			}
			for (int k = pointBlocks_ - points; k < pointBlocks_; ++k)
				vacantBlocks_.push_back(k);
		}
	}
	chunkBegin_[Coloring::colors] = int(chunks_.size());
}

/// Into the next slot of its row; a prescribed side gets a record of its own, which nothing moves.
void Layout::place(Pair& pair, int color)
{
	Row& row        = this->row(color, pair.points);
	pair.slot       = row.nextSlot++;
	const int block = pair.slot / blockWidth, lane = pair.slot % blockWidth;
	pair.pointBlock = row.firstPoint + (block - row.firstBlock) * pair.points;
	pairBlocks_[block].body1[lane] = offsetOf(kind_[pair.body1] == BodyKind::regular ? pair.body1 : ownRecord());
	pairBlocks_[block].body2[lane] = offsetOf(kind_[pair.body2] == BodyKind::regular ? pair.body2 : ownRecord());
}

} // namespace rcr

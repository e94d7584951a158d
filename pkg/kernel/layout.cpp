#include "layout.hpp"

#include <algorithm>

namespace rcr {

namespace {

	constexpr int    chunkBlocks = 16;   // 128 pairs, under a microsecond: small against a colour, large against sharing it
	constexpr double maxVacancy  = 0.15; // share of empty slots beyond which all is laid out anew

	BodyKind kindOf(const InverseMass& m)
	{
		if (m.x == 0 && m.y == 0 && m.rotation == 0) return BodyKind::prescribed;
		return m.x == m.y && m.x > 0 ? BodyKind::regular : BodyKind::special;
	}

	std::vector<Pair> findPairs(const ContactProblem& problem)
	{
		std::vector<Pair> pairs;
		pairs.reserve(problem.points.size());
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const ContactPoint& c = problem.points[k];
			if (!pairs.empty() && pairs.back().points == 1 && pairs.back().body1 == c.body1 && pairs.back().body2 == c.body2)
				pairs.back().points = 2;
			else
				pairs.push_back({ c.body1, c.body2, std::int32_t(k), 1, Pair::outside });
		}
		return pairs;
	}

	bool inOrder(const std::vector<Pair>& pairs)
	{
		return std::is_sorted(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.before(b); });
	}

} // namespace

bool Layout::update(const ContactProblem& problem)
{
	vacated_.clear();
	std::vector<Pair> pairs = findPairs(problem);
	const bool        kept  = sortBodies(problem) && keep(pairs);
	if (!kept) make(pairs);
	pairs_ = std::move(pairs);
	return !kept;
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

/// Pairs that were there before take their slots, the others get one; false if there is no good way.
bool Layout::keep(std::vector<Pair>& pairs)
{
	const auto same = [](const Pair& a, const Pair& b) { return a.sameAs(b); };
	if (std::equal(pairs.begin(), pairs.end(), pairs_.begin(), pairs_.end(), same)) {
		for (std::size_t k = 0; k < pairs.size(); ++k)
			pairs[k].slot = pairs_[k].slot;
		return true;
	}
	if (!inOrder(pairs) || !inOrder(pairs_)) return false;
	std::vector<Pair*> incoming;
	auto               old = pairs_.begin();
	for (Pair& pair : pairs) {
		for (; old != pairs_.end() && !old->sameAs(pair) && !pair.before(*old); ++old)
			vacate(*old);
		if (old != pairs_.end() && old->sameAs(pair)) pair.slot = old++->slot;
		else
			incoming.push_back(&pair);
	}
	for (; old != pairs_.end(); ++old)
		vacate(*old);
	for (Pair* pair : incoming)
		place(*pair);
	// a block for every colour and number of points may stand half empty in any case
	return double(blockWidth) * (double(blocks_.size()) - 2 * Coloring::colors) <= double(pairs.size()) / (1 - maxVacancy);
}

/// Lays everything out anew: colours first, so that the blocks of each stand together.
void Layout::make(std::vector<Pair>& pairs)
{
	blocks_.clear();
	pairBlocks_.clear();
	chunks_.clear();
	vacated_.clear();
	pointBlocks_ = 0;
	std::fill(std::begin(chunkBegin_), std::end(chunkBegin_), 0);
	std::vector<bool> limits(kind_.size());
	for (std::size_t i = 0; i < kind_.size(); ++i)
		limits[i] = kind_[i] != BodyKind::prescribed;
	coloring_ = Coloring(std::move(limits));

	int                      count[Coloring::colors][2] = {};
	std::vector<signed char> colors(pairs.size(), Coloring::none);
	for (std::size_t k = 0; k < pairs.size(); ++k) {
		pairs[k].slot = Pair::outside;
		if (!packable(pairs[k])) continue;
		const int color = coloring_.take(pairs[k].body1, pairs[k].body2);
		if (color == Coloring::none) continue;
		colors[k] = static_cast<signed char>(color);
		++count[color][pairs[k].points - 1];
	}
	for (int color = 0; color < Coloring::colors; ++color)
		for (int points : { 2, 1 }) {
			vacant(color, points).clear();
			addBlocks(color, points, (count[color][points - 1] + blockWidth - 1) / blockWidth);
			std::reverse(vacant(color, points).begin(), vacant(color, points).end()); // filled from the front
		}
	for (std::size_t k = 0; k < pairs.size(); ++k)
		if (colors[k] != Coloring::none) settle(pairs[k], colors[k]);
}

bool Layout::packable(const Pair& pair) const
{
	const BodyKind a = kind_[pair.body1], b = kind_[pair.body2];
	return (a == BodyKind::regular && b != BodyKind::special) || (b == BodyKind::regular && a != BodyKind::special);
}

/// Gives the pair a slot of some colour, in a new block if need be.
void Layout::place(Pair& pair)
{
	pair.slot = Pair::outside;
	if (!packable(pair)) return;
	const int color = coloring_.take(pair.body1, pair.body2);
	if (color == Coloring::none) return;
	if (vacant(color, pair.points).empty()) addBlocks(color, pair.points, 1);
	settle(pair, color);
}

/// Into a vacant slot of that colour.
void Layout::settle(Pair& pair, int color)
{
	pair.slot = vacant(color, pair.points).back();
	vacant(color, pair.points).pop_back();
	PairBlock& block = pairBlocks_[pair.slot / blockWidth];
	const int  lane  = pair.slot % blockWidth;
	if (kind_[pair.body1] == BodyKind::regular) block.body1[lane] = pair.body1;
	if (kind_[pair.body2] == BodyKind::regular) block.body2[lane] = pair.body2;
}

void Layout::vacate(const Pair& pair)
{
	if (pair.slot == Pair::outside) return;
	const Block& block = blocks_[pair.slot / blockWidth];
	coloring_.release(pair.body1, pair.body2, block.color);
	vacant(block.color, block.points).push_back(pair.slot);
	vacated_.push_back(pair.slot);
	clear(pair.slot);
}

/// Both sides of the slot are its own records, which nothing moves.
void Layout::clear(int slot)
{
	const std::int32_t own                               = std::int32_t(kind_.size()) + 2 * slot;
	pairBlocks_[slot / blockWidth].body1[slot % blockWidth] = own;
	pairBlocks_[slot / blockWidth].body2[slot % blockWidth] = own + 1;
}

void Layout::addBlocks(int color, int points, int count)
{
	const int first = int(blocks_.size());
	std::vector<Chunk> added;
	for (int b = 0; b < count; b += chunkBlocks)
		added.push_back({ first + b, std::min(chunkBlocks, count - b), pointBlocks_ + b * points, points });
	chunks_.insert(chunks_.begin() + chunkBegin_[color + 1], added.begin(), added.end());
	for (int c = color + 1; c <= Coloring::colors; ++c)
		chunkBegin_[c] += int(added.size());
	for (int b = 0; b < count; ++b, pointBlocks_ += points) {
		blocks_.push_back({ pointBlocks_, points, color });
		pairBlocks_.emplace_back();
		for (int slot = (first + b) * blockWidth; slot < (first + b + 1) * blockWidth; ++slot) {
			clear(slot);
			vacant(color, points).push_back(slot);
		}
	}
}

} // namespace rcr

#include "sweep/layout/layout.hpp"

#include <algorithm>
#include <numeric>

#include "parallel/thread_team.hpp"

namespace rcr {

namespace {

	constexpr int    smallIslandPairs = 16;    // pairs of an island up to which all of it is overflow
	constexpr int    loneIslandPairs  = 1024;  // pairs of an island up to which one thread sweeps it
	constexpr int    slabPairs        = 2048;  // that a slab has in the mean: twenty times as many as a joint
	constexpr int    mostSlabs        = 16;    // of an island; a joint section joins `jointSlabs` of them to the next ones
	constexpr int    jointSlabs       = 4;     // fewer would leave too many slots vacant
	constexpr int    leastModelPart   = 4;     // a model needs 1/4 of an island's pairs to have blocks of its own
	constexpr double leverTolerance   = 1e-10; // lever over arm [-] that counts as none: rounding of positions far from the origin

	BodyKind kindOf(const InverseMass& m)
	{
		if (m.x == 0 && m.y == 0 && m.rotation == 0) return BodyKind::prescribed;
		return m.x == m.y && m.x > 0 ? BodyKind::regular : BodyKind::special;
	}

	/// Whether the normal velocity at a point depends on the rotation of a body.
	bool turns(const InverseMass& m, const Twist& v, Vec2 arm, Vec2 normal)
	{
		const double lever = cross(arm, normal);
		return (m.rotation != 0 || v.rotation != 0) && lever * lever > leverTolerance * leverTolerance * dot(arm, arm);
	}

	/// The least model that serves two points.
	Model both(Model a, Model b)
	{
		return a == b ? a : rough(a) || rough(b) ? Model::frictional : Model::frictionless;
	}

	/// The representative of a body among those it is joined to.
	int root(std::vector<std::int32_t>& parent, int body)
	{
		while (parent[body] != body)
			body = parent[body] = parent[parent[body]];
		return body;
	}

} // namespace

bool Layout::update(const ContactProblem& problem, const Reductions& reductions, ThreadTeam& team)
{
	const bool sameReductions = reductions == reductions_;
	reductions_               = reductions;
	const bool sameCell   = stretches_ == problem.stretches();
	stretches_            = problem.stretches();
	const bool sameBodies = sortBodies(problem), samePairs = findPairs(problem, team);
	if (sameReductions && sameCell && sameBodies && samePairs && reductions.layout) return false;
	findIslands();
	sortPairs();
	for (Island& island : islands_)
		chooseModels(island);
	sortSections();
	numberRecords();
	chunks_.clear();
	vacant_.clear();
	pairBlocks_.clear();
	overflow_.clear();
	columns_ = pointBlocks_ = 0;
	coloring_.reset(records_);
	color_.resize(pairs_.size());
	for (const auto& [begin, end] : { std::pair(0, slabSections_), std::pair(slabSections_, int(sections_.size())) }) // sections of a part share no body
		team.parallelFor(begin, end, [&](int k) { color(sections_[k]); });
	for (Section& section : sections_)
		makeBlocks(section);
	team.parallelFor(0, int(sections_.size()), [&](int k) { place(sections_[k]); });
	for (Island& island : islands_)
		listOverflow(island);
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

/// The least model that serves a point.
Model Layout::need(const ContactProblem& problem, const ContactPoint& c) const
{
	const bool isRough = c.friction != 0 || !reductions_.frictionless;
	const auto turned  = [&](int body, Vec2 arm) { return turns(problem.inverseMass[body], problem.freeVelocity[body], arm, c.normal); };
	if (!reductions_.discs || turned(c.body1, c.arm1) || turned(c.body2, c.arm2)) return isRough ? Model::frictional : Model::frictionless;
	return isRough ? Model::round : Model::central;
}

/// Joins neighbouring points of the same bodies, two at most; false if the pairs or their needs differ from before.
bool Layout::findPairs(const ContactProblem& problem, ThreadTeam& team)
{
	const std::size_t points = problem.points.size(), before = pairs_.size();
	kinds_.resize(points);
	team.forEach(points, [&](std::size_t k) {
		const ContactPoint& c = problem.points[k];
		kinds_[k]             = { c.body1, c.body2, need(problem, c), c.drifts() };
	});
	std::size_t count = 0;
	bool        same  = true;
	for (std::size_t k = 0; k < points; ++count) {
		const Kind &   c = kinds_[k], &next = kinds_[std::min(k + 1, points - 1)];
		const bool     joins = k + 1 < points && next.body1 == c.body1 && next.body2 == c.body2;
		const Model    needs = joins ? both(c.needs, next.needs) : c.needs;
		const LaidPair pair { c.body1, c.body2, std::int32_t(k), joins ? 2 : 1, needs, needs, c.drifts || (joins && next.drifts), LaidPair::noSlot, 0 };
		if (count == pairs_.size()) pairs_.push_back(pair);
		LaidPair& old = pairs_[count];
		// `firstPoint` follows from the pairs before
		if (old.body1 != pair.body1 || old.body2 != pair.body2 || old.points != pair.points || old.needs != needs || old.drifts != pair.drifts) same = false;
		if (!same) old = pair;
		k += pair.points;
	}
	pairs_.resize(count);
	return same && count == before;
}

bool Layout::packable(const LaidPair& pair) const
{
	const BodyKind a = kind_[pair.body1], b = kind_[pair.body2];
	if (pair.drifts) return false;
	return (a == BodyKind::regular && b != BodyKind::special) || (b == BodyKind::regular && a != BodyKind::special);
}

/// Numbers the connected parts in the order of their first pairs.
void Layout::findIslands()
{
	std::vector<std::int32_t> parent(kind_.size()), number(kind_.size(), none);
	std::iota(parent.begin(), parent.end(), 0);
	int whole = none; // without this reduction all is one
	int cell  = none; // a body at its boundary
	const auto join = [&](int body1, int body2) {
		const int a = root(parent, body1), b = root(parent, body2);
		parent[std::max(a, b)] = std::min(a, b);
	};
	for (const LaidPair& pair : pairs_) {
		if (moves(pair.body1) && moves(pair.body2)) join(pair.body1, pair.body2);
		if (!stretches_ || !pair.drifts) continue;
		const int body = moves(pair.body1) ? pair.body1 : pair.body2;
		if (!moves(body)) continue;
		if (cell != none) join(cell, body);
		cell = body;
	}
	island_.assign(kind_.size(), none);
	islands_.clear();
	for (const LaidPair& pair : pairs_) {
		const int body = moves(pair.body1) ? pair.body1 : pair.body2;
		if (!moves(body)) continue;
		std::int32_t& island = reductions_.islands ? number[root(parent, body)] : whole;
		if (island == none) {
			island = int(islands_.size());
			islands_.push_back({});
		}
		for (int one : { pair.body1, pair.body2 })
			if (moves(one)) island_[one] = island;
		islands_[island].cell |= stretches_ && pair.drifts;
		++islands_[island].pairs.end;
		islands_[island].points += pair.points;
	}
}

/// Sorts the pairs by island; pairs of two prescribed bodies belong to none.
void Layout::sortPairs()
{
	int next = 0;
	for (Island& island : islands_) {
		const int count    = island.pairs.end;
		island.pairs.begin = island.pairs.end = next;
		next += count;
	}
	byIsland_.resize(next);
	for (std::size_t k = 0; k < pairs_.size(); ++k) {
		pairs_[k].slot   = LaidPair::noSlot;
		const int island = islandOf(pairs_[k]);
		if (island != none) byIsland_[islands_[island].pairs.end++] = int(k);
	}
}

/// Cuts an island into slabs: two where several threads may work on it, more where it is large. A small one has none, it is all overflow.
void Layout::cut(Island& island)
{
	const int pairs    = island.pairs.end - island.pairs.begin;
	island.shared      = pairs > loneIslandPairs;
	island.slabs.begin = island.slabs.end = int(sections_.size());
	if (pairs <= smallIslandPairs) return;
	edges_.clear();
	for (int k = island.pairs.begin; k < island.pairs.end; ++k) {
		const LaidPair& pair = pairs_[byIsland_[k]];
		if (!packable(pair)) continue;
		const int body1 = moves(pair.body1) ? pair.body1 : pair.body2, body2 = moves(pair.body2) ? pair.body2 : pair.body1;
		edges_.push_back({ body1, body2 });
	}
	if (edges_.empty()) return;
	const int count  = island.shared ? std::clamp(pairs / (2 * slabPairs) * 2, 2, mostSlabs) : 1;
	island.slabs.end = island.slabs.begin + slabs_.cut(edges_, count, island.slabs.begin);
	sections_.resize(island.slabs.end);
}

/// The section where a pair stands; none for overflow.
int Layout::sectionOf(const LaidPair& pair) const
{
	const int island = islandOf(pair);
	if (island == none || islands_[island].slabs.begin == islands_[island].slabs.end || !packable(pair)) return none;
	const int slab1 = slabs_.of(moves(pair.body1) ? pair.body1 : pair.body2), slab2 = slabs_.of(moves(pair.body2) ? pair.body2 : pair.body1);
	if (slab1 == slab2) return slab1;
	return islands_[island].joints.begin + (std::min(slab1, slab2) - islands_[island].slabs.begin) / jointSlabs;
}

/// Makes the sections and sorts the pairs by them.
void Layout::sortSections()
{
	sections_.clear();
	slabs_.reset(kind_.size());
	for (Island& island : islands_)
		cut(island);
	slabSections_ = int(sections_.size());
	for (Island& island : islands_) {
		const int slabs     = island.slabs.end - island.slabs.begin;
		island.joints.begin = int(sections_.size());
		sections_.resize(sections_.size() + (std::max(slabs - 1, 0) + jointSlabs - 1) / jointSlabs);
		island.joints.end = int(sections_.size());
	}
	std::vector<std::int32_t> section(byIsland_.size());
	for (std::size_t k = 0; k < byIsland_.size(); ++k) {
		section[k] = sectionOf(pairs_[byIsland_[k]]);
		if (section[k] != none) ++sections_[section[k]].pairs.end;
	}
	int next = 0;
	for (Section& section : sections_) {
		const int count     = section.pairs.end;
		section.pairs.begin = section.pairs.end = next;
		next += count;
	}
	bySection_.resize(next);
	for (std::size_t k = 0; k < byIsland_.size(); ++k)
		if (section[k] != none) bySection_[sections_[section[k]].pairs.end++] = byIsland_[k];
}

/// Numbers the records of bodies, island after island, slab after slab; bodies without an island get whole records.
void Layout::numberRecords()
{
	// a place for each slab and one more for the loose bodies of each island, in the order of their records
	const auto place = [&](int body) { return (slabs_.of(body) != Slabs::none ? slabs_.of(body) : islands_[island_[body]].slabs.end) + island_[body]; };
	std::vector<std::int32_t> bodies(islands_.empty() ? 0 : islands_.back().slabs.end + islands_.size()), next(bodies.size());
	for (std::size_t body = 0; body < kind_.size(); ++body)
		if (island_[body] != none) ++bodies[place(int(body))];
	records_          = 0;
	const auto number = [&](Range& records, int at, bool central) {
		next[at] = records.begin = records_;
		records_ += central ? (bodies[at] + 1) / 2 * 2 : 2 * bodies[at];
		records.end = records_;
	};
	for (std::size_t k = 0; k < islands_.size(); ++k) {
		Island& island = islands_[k];
		for (int slab = island.slabs.begin; slab < island.slabs.end; ++slab)
			number(sections_[slab].records, slab + int(k), island.central);
		number(island.loose, island.slabs.end + int(k), island.central);
	}
	record_.resize(kind_.size());
	for (std::size_t body = 0; body < kind_.size(); ++body) {
		if (island_[body] == none) {
			record_[body] = ownRecords(1);
			continue;
		}
		std::int32_t& record = next[place(int(body))];
		record_[body]        = record;
		record += islands_[island_[body]].central ? 1 : 2;
	}
}

/// Pairs that no colour has taken, in the order of the problem.
void Layout::listOverflow(Island& island)
{
	island.overflow.begin = int(overflow_.size());
	for (int k = island.pairs.begin; k < island.pairs.end; ++k)
		if (pairs_[byIsland_[k]].slot == LaidPair::noSlot) overflow_.push_back(byIsland_[k]);
	island.overflow.end = int(overflow_.size());
}

/// Gives each pair the least model that serves it. A model of few pairs is not used, and the central one only where all pairs of
/// the island are central: its records are halves.
void Layout::chooseModels(Island& island)
{
	int       count[models] = {};
	const int all           = island.pairs.end - island.pairs.begin;
	for (int k = island.pairs.begin; k < island.pairs.end; ++k)
		++count[int(pairs_[byIsland_[k]].needs)];
	const bool small = all <= smallIslandPairs;
	const auto many  = [&](int pairs) { return small || leastModelPart * pairs >= all; };
	const bool rounds = many(count[int(Model::round)]), smooth = many(count[int(Model::frictionless)] + count[int(Model::central)]);
	island.central    = count[int(Model::central)] == all && !small;
	const auto served = [&](Model needs) {
		if (needs == Model::frictional) return needs;
		if (needs == Model::round) return rounds ? needs : Model::frictional;
		if (!smooth) return rounds && needs == Model::central ? Model::round : Model::frictional;
		return island.central || small ? needs : Model::frictionless;
	};
	for (int k = island.pairs.begin; k < island.pairs.end; ++k) {
		LaidPair& pair = pairs_[byIsland_[k]];
		pair.model     = served(pair.needs);
	}
}

ModelSummary Layout::summary() const
{
	ModelSummary      s;
	std::vector<bool> turns(kind_.size());
	for (const LaidPair& pair : pairs_) {
		if (islandOf(pair) == none) continue;
		++s.pairs;
		s.points += pair.points;
		s.frictionalPoints += rough(pair.model) ? pair.points : 0;
		if (pair.model != Model::central) turns[pair.body1] = turns[pair.body2] = true;
	}
	for (std::size_t body = 0; body < kind_.size(); ++body) {
		s.fixed += kind_[body] == BodyKind::prescribed;
		s.bodies += island_[body] != none;
		s.rotating += island_[body] != none && turns[body];
	}
	s.islands = int(islands_.size());
	return s;
}

} // namespace rcr

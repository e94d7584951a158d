#include "sweep/layout/layout.hpp"

#include <limits>

#include "parallel/thread_team.hpp"
#include "problem/coulomb.hpp"
#include "problem/list_by_key.hpp"

namespace rcr {

namespace {

	constexpr int maxOverflowIsland = 16;   // pairs of an island that is all overflow
	constexpr int maxSerialIsland   = 1024; // pairs of an island for one thread
	constexpr int partitionPairs = 2048; // mean of a partition: twenty times those of an interface
	constexpr int maxPartitions  = 16;   // of an island
	constexpr int sectionInterfaces = 4; // a smaller number would leave too many slots empty
	constexpr int minModelShare     = 4; // a model needs 1/4 of the pairs of an island

	BodyKind kindOf(const InverseMass& m)
	{
		if (m.prescribed()) return BodyKind::prescribed;
		return m.x == m.y && m.x > 0 ? BodyKind::regular : BodyKind::special;
	}

	/// Returns true if the normal velocity at a point depends on the rotation of a body.
	bool hasLever(const InverseMass& m, const PlanarVector& v, Vec2 arm, Vec2 normal)
	{
		const double lever = cross(arm, normal);
		return (m.rotation != 0 || v.rotation != 0)
		        && lever * lever > negligibleLever * negligibleLever * dot(arm, arm);
	}

	/// The cheapest model that holds for two points.
	Model common(Model a, Model b)
	{
		return a == b                              ? a
		        : hasFriction(a) || hasFriction(b) ? Model::frictional
		                                           : Model::frictionless;
	}

	/// Lists pairs by island or section, and sets the range of each in the list.
	template <class Part, class ForEach>
	void listPairs(std::vector<Part>& parts, std::vector<std::int32_t>& pairs, ForEach forEach)
	{
		std::vector<std::int32_t> begin;
		listByKey(parts.size(), begin, pairs, forEach);
		for (std::size_t k = 0; k < parts.size(); ++k)
			parts[k].pairs = { begin[k], begin[k + 1] };
	}

	/// Returns true if the stretch rate of a cell may lag behind a sweep: the cell responds less
	/// than half as much to all impulses together as each contact to its own.
	bool mayLag(const ContactProblem& problem)
	{
		if (!problem.stretches()) return false;
		double cell = 0, least = std::numeric_limits<double>::infinity();
		for (const ContactPoint& c : problem.points) {
			const double w = delassus(problem, c).nn;
			if (w <= 0) continue;
			const Vec2 arm = problem.stretchArm(c);
			cell += dot(problem.inverseStretchMass, componentwise(arm, arm));
			least = std::min(least, w);
		}
		return cell < 0.5 * least;
	}

} // namespace

bool Layout::update(const ContactProblem& problem, const Reductions& reductions, ThreadTeam& team)
{
	const bool sameReductions = reductions == reductions_;
	reductions_               = reductions;
	const bool lags     = mayLag(problem);
	const bool sameCell = stretches_ == problem.stretches() && cellLags_ == lags;
	stretches_ = problem.stretches(), cellLags_ = lags;
	const bool sameBodies = classifyBodies(problem), samePairs = findPairs(problem, team);
	if (sameReductions && sameCell && sameBodies && samePairs && reductions.layout) return false;
	findIslands();
	sortPairs();
	for (Island& island : islands_)
		chooseModels(island);
	makeSections();
	numberRecords();
	chunks_.clear();
	vacant_.clear();
	pairBlocks_.clear();
	overflow_.clear();
	columns_ = pointBlocks_ = 0;
	coloring_ = Coloring(records_);
	color_.resize(pairs_.size());
	const auto colorSection = [&](int k) { color(sections_[k]); };
	team.parallelFor(0, partitionCount_, colorSection);
	team.parallelFor(partitionCount_, int(sections_.size()), colorSection);
	for (Section& section : sections_)
		makeBlocks(section);
	team.parallelFor(0, int(sections_.size()), [&](int k) { place(sections_[k]); });
	for (Island& island : islands_)
		listOverflow(island);
	return true;
}

/// Finds the kinds of the bodies. Returns false if one has changed.
bool Layout::classifyBodies(const ContactProblem& problem)
{
	bool same = bodyKind_.size() == problem.inverseMass.size();
	bodyKind_.resize(problem.inverseMass.size());
	for (std::size_t i = 0; i < bodyKind_.size(); ++i) {
		const BodyKind kind = kindOf(problem.inverseMass[i]);
		same                = same && kind == bodyKind_[i];
		bodyKind_[i]        = kind;
	}
	return same;
}

/// The cheapest model that holds for a point.
Model Layout::requiredModel(const ContactProblem& problem, const ContactPoint& c) const
{
	if (c.rolls()) return Model::rolling;
	const bool friction = c.friction != 0 || !reductions_.frictionless;
	const auto lever    = [&](int body, Vec2 arm) {
        return hasLever(problem.inverseMass[body], problem.freeVelocity[body], arm, c.normal);
	};
	if (!reductions_.discs || lever(c.body1, c.arm1) || lever(c.body2, c.arm2))
		return friction ? Model::frictional : Model::frictionless;
	return friction ? Model::noLever : Model::frictionlessDisc;
}

/// Joins at most two consecutive points of the same bodies to a pair. Returns false if a pair or
/// its required model has changed.
bool Layout::findPairs(const ContactProblem& problem, ThreadTeam& team)
{
	const std::size_t points = problem.points.size(), before = pairs_.size();
	pointKeys_.resize(points);
	team.forEach(points, [&](std::size_t k) {
		const ContactPoint& c = problem.points[k];
		pointKeys_[k] = { c.body1, c.body2, requiredModel(problem, c), c.crossesMovingCell(),
			c.friction != 0 || c.rolls() };
	});
	std::size_t count = 0;
	bool        same  = true;
	for (std::size_t k = 0; k < points; ++count) {
		const PointKey & c = pointKeys_[k], &next = pointKeys_[std::min(k + 1, points - 1)];
		const bool       joins = k + 1 < points && next.body1 == c.body1 && next.body2 == c.body2
		        && c.required != Model::rolling && next.required != Model::rolling;
		const Model      required = joins ? common(c.required, next.required) : c.required;
		const PackedPair pair { c.body1, c.body2, std::int32_t(k), joins ? 2 : 1, required,
			required, c.crossesMovingCell || (joins && next.crossesMovingCell),
			c.frictional || (joins && next.frictional), none, 0 };
		if (count == pairs_.size()) pairs_.push_back(pair);
		PackedPair& old = pairs_[count];
		// firstPoint follows from the earlier pairs
		if (old.body1 != pair.body1 || old.body2 != pair.body2 || old.points != pair.points
		        || old.required != required || old.crossesMovingCell != pair.crossesMovingCell
		        || old.frictional != pair.frictional)
			same = false;
		if (!same) old = pair;
		k += pair.points;
	}
	pairs_.resize(count);
	return same && count == before;
}

bool Layout::packable(const PackedPair& pair) const
{
	const BodyKind a = bodyKind_[pair.body1], b = bodyKind_[pair.body2];
	if (pair.crossesMovingCell) return false;
	if (stretches_) return cellLags_ && a == BodyKind::regular && b == BodyKind::regular;
	return (a == BodyKind::regular && b != BodyKind::special)
	        || (b == BodyKind::regular && a != BodyKind::special);
}

/// Sorts the pairs by island. Pairs of two prescribed bodies belong to none.
void Layout::sortPairs()
{
	for (PackedPair& pair : pairs_)
		pair.slot = none;
	listPairs(islands_, byIsland_, [&](auto add) {
		for (std::size_t k = 0; k < pairs_.size(); ++k)
			if (const int island = islandOf(pairs_[k]); island != none) add(island, int(k));
	});
}

/// Cuts an island into partitions: at least two if several threads may sweep it. A small island has
/// none and is all overflow.
void Layout::cut(Island& island)
{
	const int pairs         = island.pairs.end - island.pairs.begin;
	island.shared           = pairs > maxSerialIsland;
	island.partitions.begin = island.partitions.end = int(sections_.size());
	if (pairs <= maxOverflowIsland) return;
	const auto list = [&](auto isEdge) {
		edges_.clear();
		for (int k = island.pairs.begin; k < island.pairs.end; ++k)
			if (isEdge(pairs_[byIsland_[k]])) edges_.push_back(movingBodies(pairs_[byIsland_[k]]));
	};
	list([&](const PackedPair& pair) { return packable(pair); });
	if (edges_.empty()) {
		list([](const PackedPair&) { return true; });
		island.shape.diameter = partitions_.measure(edges_);
		return;
	}
	const int count = island.shared ? std::clamp(pairs / (2 * partitionPairs) * 2, 2, maxPartitions)
	                                : 1;
	island.partitions.end = island.partitions.begin
	        + partitions_.cut(edges_, count, island.partitions.begin);
	island.shape.diameter = partitions_.levels();
	sections_.resize(island.partitions.end);
}

/// The section of a pair; none for overflow.
int Layout::sectionOf(const PackedPair& pair) const
{
	const int number = islandOf(pair);
	if (number == none || !packable(pair)) return none;
	const Island& island = islands_[number];
	if (island.partitions.begin == island.partitions.end) return none;
	const auto [body1, body2] = movingBodies(pair);
	const int partition1 = partitions_.of(body1), partition2 = partitions_.of(body2);
	if (partition1 == partition2) return partition1;
	const int interface = std::min(partition1, partition2) - island.partitions.begin;
	return island.interfaces.begin + interface / sectionInterfaces;
}

/// Makes the sections and sorts the pairs by section.
void Layout::makeSections()
{
	sections_.clear();
	partitions_.reset(bodyKind_.size());
	for (Island& island : islands_)
		cut(island);
	partitionCount_ = int(sections_.size());
	for (Island& island : islands_) {
		const int partitions    = island.partitions.end - island.partitions.begin;
		island.interfaces.begin = int(sections_.size());
		sections_.resize(sections_.size()
		        + (std::max(partitions - 1, 0) + sectionInterfaces - 1) / sectionInterfaces);
		island.interfaces.end = int(sections_.size());
	}
	std::vector<std::int32_t> section(byIsland_.size());
	for (std::size_t k = 0; k < byIsland_.size(); ++k)
		section[k] = sectionOf(pairs_[byIsland_[k]]);
	listPairs(sections_, bySection_, [&](auto add) {
		for (std::size_t k = 0; k < byIsland_.size(); ++k)
			if (section[k] != none) add(section[k], byIsland_[k]);
	});
}

/// Numbers the records of bodies: island after island, partition after partition. Bodies without an
/// island get whole records.
void Layout::numberRecords()
{
	// a place for each partition of an island, then one for its bodies with overflow pairs only
	const auto place = [&](int body) {
		const int partition = partitions_.of(body), island = island_[body];
		return (partition != none ? partition : islands_[island].partitions.end) + island;
	};
	const std::size_t places
	        = islands_.empty() ? 0 : islands_.back().partitions.end + islands_.size();
	std::vector<std::int32_t> begin, bodies;
	listByKey(places, begin, bodies, [&](auto add) {
		for (std::size_t body = 0; body < bodyKind_.size(); ++body)
			if (island_[body] != none) add(place(int(body)), int(body));
	});
	records_ = 0;
	record_.resize(bodyKind_.size());
	const auto number = [&](Range& records, int at, bool half) {
		records.begin = records_;
		for (int k = begin[at]; k < begin[at + 1]; ++k) {
			record_[bodies[k]] = records_;
			records_ += half ? 1 : 2;
		}
		records_ += records_ % 2;
		records.end = records_;
	};
	for (std::size_t k = 0; k < islands_.size(); ++k) {
		Island& island = islands_[k];
		for (int p = island.partitions.begin; p < island.partitions.end; ++p)
			number(sections_[p].records, p + int(k), island.halfRecords);
		number(island.overflowRecords, island.partitions.end + int(k), island.halfRecords);
	}
	for (std::size_t body = 0; body < bodyKind_.size(); ++body)
		if (island_[body] == none) record_[body] = appendRecords(1);
}

/// Lists the pairs without a slot, in the order of the problem.
void Layout::listOverflow(Island& island)
{
	island.overflow.begin = int(overflow_.size());
	for (int k = island.pairs.begin; k < island.pairs.end; ++k)
		if (pairs_[byIsland_[k]].slot == none) overflow_.push_back(byIsland_[k]);
	island.overflow.end = int(overflow_.size());
}

/// Gives each pair the cheapest model that holds, if enough pairs of the island have it. Uses the
/// model frictionlessDisc only if all pairs have it, because its records are halves.
void Layout::chooseModels(Island& island)
{
	int       count[models] = {};
	const int all           = island.pairs.end - island.pairs.begin;
	for (int k = island.pairs.begin; k < island.pairs.end; ++k)
		++count[int(pairs_[byIsland_[k]].required)];
	island.shape.rolls = count[int(Model::rolling)] > 0;
	const bool small  = all <= maxOverflowIsland;
	const auto many   = [&](int pairs) { return small || minModelShare * pairs >= all; };
	const bool discs  = many(count[int(Model::noLever)]),
	           smooth = many(count[int(Model::frictionless)] + count[int(Model::frictionlessDisc)]);
	island.halfRecords = count[int(Model::frictionlessDisc)] == all && !small;
	const auto chosen  = [&](Model required) {
        if (required <= Model::frictional) return required;
        if (required == Model::noLever) return discs ? required : Model::frictional;
        if (!smooth)
            return discs && required == Model::frictionlessDisc ? Model::noLever
			                                                     : Model::frictional;
        return island.halfRecords || small ? required : Model::frictionless;
	};
	for (int k = island.pairs.begin; k < island.pairs.end; ++k) {
		PackedPair& pair = pairs_[byIsland_[k]];
		pair.model       = chosen(pair.required);
	}
}

} // namespace rcr

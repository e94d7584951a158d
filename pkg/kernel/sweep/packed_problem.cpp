#include "sweep/packed_problem.hpp"

#include "parallel/timed.hpp"
#include "problem/coulomb.hpp"
#include "problem/list_by_key.hpp"
#include "sweep/packed_island.hpp"

namespace rcr {

constexpr double blockedGyration = 1e30; // of a body that cannot turn [m]; its square is finite

static double inverseGyration(const InverseMass& m)
{
	if (m.x != m.y || m.x <= 0) return 1; // prescribed or special bodies: any scale is valid
	return m.rotation > 0 ? std::sqrt(m.rotation / m.x) : 1 / blockedGyration;
}

/// The initial impulse. Without friction, the tangential impulse is zero.
static LocalVector initialImpulse(const ContactProblem& problem, int point)
{
	const LocalVector p = problem.impulse[point];
	return { p.n, problem.points[point].friction == 0 ? 0 : p.t };
}

/// Tangential velocity due to constant spins, which half records do not hold [m/s].
static double spinSlip(const ContactProblem& problem, const ContactPoint& c)
{
	return problem.freeVelocity[c.body2].rotation * dot(c.arm2, c.normal)
	        - problem.freeVelocity[c.body1].rotation * dot(c.arm1, c.normal);
}

// ---- input

void PackedProblem::load(const ContactProblem& problem, int lanes, const Reductions& reductions)
{
	kernels_         = &packedKernels(lanes);
	singleKernels_   = &singleKernels(lanes);
	const bool isNew = timed([&](double seconds) { layoutSeconds_ += seconds; },
	        [&] { return layout_.update(problem, reductions, team); });
	stretches_       = problem.stretches();
	cellLags_        = layout_.cellLags();
	if (isNew) {
		const int layouts = summary_.layouts + 1;
		summary_          = layout_.summary();
		summary_.layouts  = layouts;
		point_.resize(layout_.columns());
		for (std::vector<Column>& saved : savedPoint_)
			saved.resize(2 * std::size_t(layout_.pointBlocks()));
		for (const Range& vacant : layout_.vacant())
			std::fill(point_.begin() + vacant.begin, point_.begin() + vacant.end, Column {});
		body_.assign(offsetOf(layout_.records()) / blockWidth + 1, {});
		oldBody_.resize(body_.size());
		singleBody_.assign(body_.size(), {}); // prescribed bodies never differ from the reference
		singleOldBody_.assign(body_.size(), {});
		singlePoint_.resize(point_.size());
		singleBias_.resize(layout_.pointBlocks());
	}
	partial_.resize(layout_.chunks().size());
	sum_.resize(layout_.chunks().size());

	const std::vector<PackedPair>& pairs = layout_.pairs();
	inverseGyration_.resize(problem.inverseMass.size());
	inverseMass_.assign(layout_.records(), {});
	team.forEach(problem.inverseMass.size(), [&](int i) {
		const InverseMass& m     = problem.inverseMass[i];
		const double       scale = inverseGyration_[i] = inverseGyration(m);
		const int          at    = layout_.record(i);
		inverseMass_[at] = { m.x, m.y, m.rotation / (scale * scale) };
		loadBody(problem, i, at, layout_.hasHalfRecord(i));
	});
	team.forEach(pairs.size(), [&](int k) {
		if (pairs[k].slot != none) fill(problem, pairs[k]);
	});
	freeBody_ = body_;
	loadCell(problem);
	overflow_.clear();
	states_.assign(islands(), {});
	for (int number = 0; number < islands(); ++number) {
		const Island& island           = layout_.islands()[number];
		states_[number].overflow.begin = int(overflow_.size());
		for (int k = island.overflow.begin; k < island.overflow.end; ++k)
			addToOverflow(problem, pairs[layout_.overflow()[k]], island.halfRecords);
		states_[number].overflow.end = int(overflow_.size());
	}
	for (std::vector<LocalVector>& saved : savedOverflow_)
		saved.resize(overflow_.size());
	for (std::size_t body = 0; body < problem.inverseMass.size(); ++body)
		if (const int island = layout_.island(int(body)); island != none)
			states_[island].mass += problem.inverseMass[body].mass();
	findYielded(problem);
	forEachIsland([](PackedIsland&& island) {
		island.prepare();
		island.recomputeVelocities();
	});
	oldBody_        = body_;
	oldStretchRate_ = stretchRate_;
}

/// Finds the islands that have yielded in an earlier pass of the step.
void PackedProblem::findYielded(const ContactProblem& problem)
{
	for (std::size_t body = 0; body < problem.yielded.size(); ++body)
		if (const int island = layout_.island(int(body)); island != none && problem.yielded[body])
			states_[island].hasYielded = true;
}

void PackedProblem::listPoints(
        std::vector<std::int32_t>& begin, std::vector<std::int32_t>& points) const
{
	listByKey(layout_.islands().size(), begin, points, [&](auto add) {
		for (const PackedPair& pair : layout_.pairs())
			if (const int island = layout_.islandOf(pair); island != none)
				for (int k = 0; k < pair.points; ++k)
					add(island, pair.firstPoint + k);
	});
}

void PackedProblem::loadBody(const ContactProblem& problem, int body, int number, bool half)
{
	const PlanarVector& v  = problem.freeVelocity[body];
	double*             to = view().recordAt(number);
	to[record::x]          = v.x;
	to[record::y]          = v.y;
	if (half) return;
	const bool regular      = layout_.kind(body) == BodyKind::regular;
	to[record::spin]        = v.rotation / inverseGyration_[body];
	to[record::inverseMass] = regular ? problem.inverseMass[body].x : 0;
}

void PackedProblem::fill(const ContactProblem& problem, const PackedPair& pair)
{
	const int        lane = pair.slot % blockWidth;
	const PairBlock& home = layout_.pairBlocks()[pair.slot / blockWidth];
	const bool       half = pair.model == Model::frictionlessDisc;
	const auto       load = [&](int body, std::uint32_t offset) { // prescribed bodies only
        if (offset != offsetOf(layout_.record(body)))
            loadBody(problem, body, recordOf(offset), half);
	};
	load(pair.body1, home.body1[lane]);
	load(pair.body2, home.body2[lane]);
	for (int i = 0; i < pair.points; ++i)
		fillPoint(problem, pair, pair.firstPoint + i,
		        &point_[pair.column + i * columnsOf(pair.model)]);
}

/// Inlining would let the compiler split the loop over one or two points into many.
[[gnu::noinline]] void PackedProblem::fillPoint(
        const ContactProblem& problem, const PackedPair& pair, int point, Column* columns)
{
	const int                    lane   = pair.slot % blockWidth;
	const bool                   half   = pair.model == Model::frictionlessDisc;
	const double                 scale1 = inverseGyration_[pair.body1];
	const double                 scale2 = inverseGyration_[pair.body2];
	const ContactPoint&          c      = problem.points[point];
	const LocalVector            p      = initialImpulse(problem, point);
	const PointColumnsOf<double> any(columns);
	any.nx()[lane]             = c.normal.x;
	any.ny()[lane]             = c.normal.y;
	any.bias()[lane]           = c.bias;
	any.pn()[lane]             = p.n;
	any.oldPn()[lane]          = p.n;
	any.tangentialBias()[lane] = half ? spinSlip(problem, c) : 0;
	if (half) {
		const FrictionlessDiscColumnsOf<double> disc(columns);
		disc.inverseMass1()[lane] = problem.inverseMass[pair.body1].x;
		disc.inverseMass2()[lane] = problem.inverseMass[pair.body2].x;
		return;
	}
	const Vec2 arm1 = scale1 * c.arm1, arm2 = scale2 * c.arm2;
	const auto setLevers = [&](const auto& to) {
		to.lever1n()[lane] = arm1.x, to.lever1t()[lane] = arm1.y;
		to.lever2n()[lane] = arm2.x, to.lever2t()[lane] = arm2.y;
	};
	if (pair.model == Model::frictionless) return setLevers(FrictionlessColumnsOf<double>(columns));
	const NoLeverColumnsOf<double> rough(columns);
	rough.friction()[lane] = c.friction;
	rough.pt()[lane]       = p.t;
	rough.oldPt()[lane]    = p.t;
	if (pair.model == Model::rolling) {
		const RollingColumnsOf<double> rolling(columns);
		rolling.pr()[lane] = rolling.oldPr()[lane] = problem.rollingImpulse[point];
		rolling.rollingFriction()[lane]            = c.rollingFriction;
		rolling.turn1()[lane]                      = c.rollingLength * scale1;
		rolling.turn2()[lane]                      = c.rollingLength * scale2;
	}
	if (pair.model <= Model::frictional) return setLevers(FrictionalColumnsOf<double>(columns));
	rough.lever1t()[lane] = dot(arm1, c.normal);
	rough.lever2t()[lane] = dot(arm2, c.normal);
}

void PackedProblem::addToOverflow(
        const ContactProblem& problem, const PackedPair& pair, bool halfRecords)
{
	const double scale1 = inverseGyration_[pair.body1], scale2 = inverseGyration_[pair.body2];
	// levers of discs are rounding
	const double lever = pair.model == Model::frictionlessDisc || pair.model == Model::noLever ? 0
	                                                                                           : 1;
	for (int k = pair.firstPoint; k < pair.firstPoint + pair.points; ++k) {
		const ContactPoint& c  = problem.points[k];
		const InverseMass & m1 = problem.inverseMass[c.body1], &m2 = problem.inverseMass[c.body2];
		const Delassus      w     = delassus(problem, c);
		const Vec2          drift = c.freeDrift(problem.stretchRate), t = perp(c.normal);
		if (w.nn <= 0) continue;
		OverflowPoint to {};
		to.w     = stretches_ && !cellLags_ ? delassusInCell(problem, c) : w;
		to.ownNn = w.nn;
		to.record1      = layout_.record(c.body1);
		to.record2      = layout_.record(c.body2);
		to.point        = k;
		to.wholeRecords = !halfRecords;
		to.normal       = c.normal;
		to.lever1n      = lever * cross(c.arm1, c.normal) * scale1;
		to.lever1t      = cross(c.arm1, t) * scale1;
		to.lever2n      = lever * cross(c.arm2, c.normal) * scale2;
		to.lever2t      = cross(c.arm2, t) * scale2;
		to.drift        = { dot(drift, c.normal),
			       dot(drift, t) + (halfRecords ? spinSlip(problem, c) : 0) };
		to.mass1        = { m1.x, m1.y, m1.rotation / (scale1 * scale1) };
		to.mass2        = { m2.x, m2.y, m2.rotation / (scale2 * scale2) };
		to.stretchArm   = c.shift + uncarriedPlace(problem, c.body2)
		        - uncarriedPlace(problem, c.body1);
		to.bias         = c.bias;
		to.friction     = c.friction;
		to.rollingFriction = c.rollingFriction;
		to.turn1           = c.rollingLength * scale1;
		to.turn2           = c.rollingLength * scale2;
		to.r = to.oldR = problem.rollingImpulseOf(k);
		to.p = to.old = initialImpulse(problem, k);
		overflow_.push_back(to);
	}
}

template <class Visit> void PackedProblem::forEachPoint(const PackedPair& pair, Visit visit)
{
	if (pair.slot == none) return;
	for (int i = 0; i < pair.points; ++i)
		visit(pair.firstPoint + i, &point_[pair.column + i * columnsOf(pair.model)],
		        pair.slot % blockWidth);
}

void PackedProblem::reload(const ContactProblem& problem, const std::vector<double>& bias)
{
	const std::vector<PackedPair>& pairs = layout_.pairs();
	std::atomic<bool> changed { false };
	const auto        load = [&](double& here, double p) {
        if (here != p) changed.store(true, std::memory_order_relaxed);
        here = p;
	};
	team.forEach(pairs.size(), [&](int k) {
		forEachPoint(pairs[k], [&](int point, Column* columns, int lane) {
			const LocalVector              p = initialImpulse(problem, point);
			const NoLeverColumnsOf<double> at(columns);
			at.bias()[lane] = bias[point];
			load(at.pn()[lane], p.n);
			at.oldPn()[lane] = p.n;
			if (!hasFriction(pairs[k].model)) return;
			load(at.pt()[lane], p.t);
			at.oldPt()[lane] = p.t;
			if (pairs[k].model != Model::rolling) return;
			const RollingColumnsOf<double> rolling(columns);
			load(rolling.pr()[lane], problem.rollingImpulse[point]);
			rolling.oldPr()[lane] = problem.rollingImpulse[point];
		});
	});
	for (OverflowPoint& c : overflow_) {
		const LocalVector p = initialImpulse(problem, c.point);
		c.bias              = bias[c.point];
		load(c.p.n, p.n);
		load(c.p.t, p.t);
		c.old = p;
		load(c.r, problem.rollingImpulseOf(c.point));
		c.oldR = c.r;
	}
	for (IslandState& state : states_) {
		if (changed) state.velocityRecomputed = false;
		state.measures.reset();
		state.hasYielded = false;
	}
	findYielded(problem);
	recomputeVelocities();
	oldBody_        = body_;
	oldStretchRate_ = stretchRate_;
}

void PackedProblem::recomputeVelocities()
{
	forEachIsland([](PackedIsland&& island) { island.recomputeVelocities(); });
}

// ---- output

void PackedProblem::store(ContactProblem& problem)
{
	const std::vector<PackedPair>& pairs = layout_.pairs();
	team.forEach(pairs.size(), [&](int k) {
		for (int point = pairs[k].firstPoint; point < pairs[k].firstPoint + pairs[k].points;
		        ++point)
			problem.impulse[point] = {};
		forEachPoint(pairs[k], [&](int point, Column* columns, int lane) {
			const NoLeverColumnsOf<double> at(columns);
			problem.impulse[point] = { at.pn()[lane],
				hasFriction(pairs[k].model) ? at.pt()[lane] : 0 };
			if (pairs[k].model == Model::rolling)
				problem.rollingImpulse[point] = RollingColumnsOf<double>(columns).pr()[lane];
		});
	});
	for (const OverflowPoint& c : overflow_) {
		problem.impulse[c.point] = c.p;
		if (c.rollingFriction > 0) problem.rollingImpulse[c.point] = c.r;
	}
	storeVelocity(problem, problem.velocity);
	if (stretches_) problem.setStretchRate(stretchRate_);
}

void PackedProblem::storeVelocity(
        const ContactProblem& problem, std::vector<PlanarVector>& velocity)
{
	recomputeVelocities();
	velocity.resize(problem.freeVelocity.size());
	team.forEach(inverseGyration_.size(), [&](int i) {
		const double* v = view().recordAt(layout_.record(i));
		velocity[i]     = problem.freeVelocity[i];
		velocity[i].x   = v[record::x];
		velocity[i].y   = v[record::y];
		if (stretches_) { // the record of a body without contacts has no stretch
			const Vec2 carried = layout_.island(i) == none ? Vec2 {} : carriedPlace(problem, i);
			const Vec2 rest    = componentwise(stretchRate_, problem.placeOf(i) - carried);
			velocity[i].x += rest.x, velocity[i].y += rest.y;
		}
		if (!layout_.hasHalfRecord(i) && problem.inverseMass[i].rotation > 0)
			velocity[i].rotation = v[record::spin] * inverseGyration_[i];
	});
}

} // namespace rcr

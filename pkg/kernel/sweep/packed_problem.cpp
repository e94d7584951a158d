#include "sweep/packed_problem.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

namespace rcr {

namespace {

	constexpr double blockedGyration = 1e30; // of a body that cannot turn: no impulse turns it, and the square is finite

	double inverseGyration(const InverseMass& m)
	{
		if (m.x != m.y || m.x <= 0) return 1; // prescribed or special: any scale will do
		return m.rotation > 0 ? std::sqrt(m.rotation / m.x) : 1 / blockedGyration;
	}

	/// The impulse to start from; the tangential one of a point that has lost its friction is no unknown.
	Impulse startOf(const ContactProblem& problem, int point)
	{
		const Impulse p = problem.impulse[point];
		return { p.n, problem.points[point].friction == 0 ? 0 : p.t };
	}

	/// The tangential velocity of spins that stay as they are.
	double slip(const ContactProblem& problem, const ContactPoint& c)
	{
		return problem.freeVelocity[c.body2].rotation * dot(c.arm2, c.normal) - problem.freeVelocity[c.body1].rotation * dot(c.arm1, c.normal);
	}

} // namespace

// ---- the problem in

void PackedProblem::load(const ContactProblem& problem, int lanes, const Reductions& reductions)
{
	kernels_       = &packedKernels(lanes);
	singleKernels_ = &singleKernels(lanes);
	const auto start = std::chrono::steady_clock::now();
	const bool fresh = layout_.update(problem, reductions, team);
	layoutSeconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	if (fresh) {
		++layouts_;
		point_.resize(layout_.columns());
		rememberedPoint_.resize(point_.size());
		for (const Range& vacant : layout_.vacant())
			std::fill(point_.begin() + vacant.begin, point_.begin() + vacant.end, Column {});
		body_.assign(layout_.records() / 2 + 1, {}); // never empty: a problem without bodies has a view, too
		oldBody_.resize(body_.size());
		singleBody_.assign(body_.size(), {}); // prescribed sides never differ from the reference
		singleOldBody_.assign(body_.size(), {});
		singlePoint_.resize(point_.size());
		singleBias_.resize(layout_.pointBlocks());
	}
	partial_.resize(layout_.chunks().size());
	sum_.resize(layout_.chunks().size());
	freeVelocity2_.resize(islands());

	const std::vector<LaidPair>& pairs = layout_.pairs();
	inverseGyration_.resize(problem.inverseMass.size());
	team.forEach(problem.inverseMass.size(), [&](int i) { inverseGyration_[i] = inverseGyration(problem.inverseMass[i]); });
	loadBodies(problem);
	team.forEach(pairs.size(), [&](int k) {
		if (pairs[k].slot != LaidPair::noSlot) fill(problem, pairs[k]);
	});
	freeBody_ = body_;
	inverseStretchMass_ = problem.inverseStretchMass;
	stretch_            = {};
	overflow_.clear();
	overflowOf_.clear();
	for (const Island& island : layout_.islands()) {
		const int begin = int(overflow_.size());
		for (int k = island.overflow.begin; k < island.overflow.end; ++k)
			addToOverflow(problem, pairs[layout_.overflow()[k]], island.central);
		overflowOf_.push_back({ begin, int(overflow_.size()) });
	}
	anew_.assign(islands(), false);
	measures_.assign(islands(), std::nullopt);
	narrowed_.assign(islands(), false);
	forEachIsland([](PackedIsland&& island) {
		island.prepare();
		island.followImpulses();
	});
	oldBody_    = body_;
	oldStretch_ = stretch_;
}

void PackedProblem::loadBody(const ContactProblem& problem, int body, int record, bool central)
{
	const Twist& v = problem.freeVelocity[body];
	const double x = layout_.kind(body) == BodyKind::regular ? problem.inverseMass[body].x : 0;
	if (central) view().halfBody(record) = { v.x, v.y };
	else
		view().wholeBody(record) = { v.x, v.y, v.rotation / inverseGyration_[body], x };
}

void PackedProblem::loadBodies(const ContactProblem& problem)
{
	team.forEach(problem.inverseMass.size(), [&](int i) { loadBody(problem, i, layout_.record(i), layout_.central(i)); });
}

void PackedProblem::fill(const ContactProblem& problem, const LaidPair& pair)
{
	const int        lane = pair.slot % blockWidth;
	const PairBlock& home = layout_.pairBlocks()[pair.slot / blockWidth];
	const bool       central = pair.model == Model::central;
	const auto       load    = [&](int body, std::uint32_t offset) { // a prescribed side
                if (offset != offsetOf(layout_.record(body))) loadBody(problem, body, recordOf(offset), central);
	};
	load(pair.body1, home.body1[lane]);
	load(pair.body2, home.body2[lane]);
	for (int i = 0; i < pair.points; ++i)
		fillPoint(problem, pair, pair.firstPoint + i, &point_[pair.column + i * columnsOf(pair.model)]);
}

/// Not inlined: the loop over one or two points is then taken apart into many.
[[gnu::noinline]] void PackedProblem::fillPoint(const ContactProblem& problem, const LaidPair& pair, int point, Column* column)
{
	const int           lane   = pair.slot % blockWidth;
	const double        scale1 = inverseGyration_[pair.body1], scale2 = inverseGyration_[pair.body2];
	const ContactPoint& c      = problem.points[point];
	const Impulse       p      = startOf(problem, point);
	auto&               any    = *reinterpret_cast<PointBlock*>(column);
	any.nx[lane]               = c.normal.x;
	any.ny[lane]               = c.normal.y;
	any.bias[lane]             = c.bias;
	any.pn[lane] = any.oldPn[lane] = p.n;
	any.slip[lane]                 = pair.model == Model::central ? slip(problem, c) : 0;
	if (pair.model == Model::central) {
		auto& disc       = *reinterpret_cast<CentralBlock*>(column);
		disc.mass1[lane] = problem.inverseMass[pair.body1].x;
		disc.mass2[lane] = problem.inverseMass[pair.body2].x;
		return;
	}
	const Vec2 arm1 = scale1 * c.arm1, arm2 = scale2 * c.arm2;
	const auto set  = [&](auto& turning) {
                turning.turn1n[lane] = arm1.x, turning.turn1t[lane] = arm1.y;
                turning.turn2n[lane] = arm2.x, turning.turn2t[lane] = arm2.y;
	};
	if (pair.model == Model::frictionless) return set(*reinterpret_cast<FrictionlessBlock*>(column));
	auto& rough          = *reinterpret_cast<RoundBlock*>(column);
	rough.friction[lane] = c.friction;
	rough.pt[lane] = rough.oldPt[lane] = p.t;
	if (pair.model == Model::frictional) return set(*reinterpret_cast<FrictionalBlock*>(column));
	rough.turn1t[lane] = dot(arm1, c.normal), rough.turn2t[lane] = dot(arm2, c.normal);
}

void PackedProblem::addToOverflow(const ContactProblem& problem, const LaidPair& pair, bool central)
{
	const double scale1 = inverseGyration_[pair.body1], scale2 = inverseGyration_[pair.body2];
	const double lever  = pair.model == Model::central || pair.model == Model::round ? 0 : 1; // rounding is none
	for (int k = pair.firstPoint; k < pair.firstPoint + pair.points; ++k) {
		const ContactPoint& c = problem.points[k];
		const InverseMass & m1 = problem.inverseMass[c.body1], &m2 = problem.inverseMass[c.body2];
		const Delassus      w = delassus(problem, c);
		const Vec2          drift = c.freeDrift(problem.stretch);
		if (w.nn <= 0) continue;
		const Vec2    t = perp(c.normal);
		const Impulse p = startOf(problem, k);
		overflow_.push_back({ layout_.record(c.body1), layout_.record(c.body2), k, !central, c.normal,
		                  lever * cross(c.arm1, c.normal) * scale1, cross(c.arm1, t) * scale1,
		                  lever * cross(c.arm2, c.normal) * scale2, cross(c.arm2, t) * scale2, { dot(drift, c.normal), dot(drift, t) + (central ? slip(problem, c) : 0) },
		                  { m1.x, m1.y, m1.rotation / (scale1 * scale1) }, { m2.x, m2.y, m2.rotation / (scale2 * scale2) },
		                  c.shift, c.bias, c.friction, w, p, p, {}, {} });
	}
}

template <class Visit> void PackedProblem::forEachPoint(const LaidPair& pair, Visit visit)
{
	if (pair.slot == LaidPair::noSlot) return;
	for (int i = 0; i < pair.points; ++i)
		visit(pair.firstPoint + i, reinterpret_cast<PointBlock&>(point_[pair.column + i * columnsOf(pair.model)]), pair.slot % blockWidth);
}

void PackedProblem::rebias(const ContactProblem& problem, const std::vector<double>& bias)
{
	const std::vector<LaidPair>& pairs = layout_.pairs();
	std::atomic<bool>            others { false }; // impulses than those that are there
	const auto                   load = [&](double& here, double p) {
                if (here != p) others.store(true, std::memory_order_relaxed);
                here = p;
	};
	team.forEach(pairs.size(), [&](int k) {
		forEachPoint(pairs[k], [&](int point, PointBlock& at, int lane) {
			const Impulse p = startOf(problem, point);
			at.bias[lane]   = bias[point];
			load(at.pn[lane], p.n);
			if (rough(pairs[k].model)) load(static_cast<RoundBlock&>(at).pt[lane], p.t);
		});
	});
	for (OverflowPoint& c : overflow_) {
		const Impulse p = startOf(problem, c.point);
		c.bias          = bias[c.point];
		load(c.p.n, p.n);
		load(c.p.t, p.t);
	}
	if (others) anew_.assign(islands(), false);
	measures_.assign(islands(), std::nullopt);
	followImpulses();
}

void PackedProblem::followImpulses()
{
	forEachIsland([](PackedIsland&& island) { island.followImpulses(); });
}

// ---- the solution out

void PackedProblem::store(ContactProblem& problem)
{
	const std::vector<LaidPair>& pairs = layout_.pairs();
	team.forEach(pairs.size(), [&](int k) {
		for (int point = pairs[k].firstPoint; point < pairs[k].firstPoint + pairs[k].points; ++point)
			problem.impulse[point] = {};
		forEachPoint(pairs[k], [&](int point, const PointBlock& at, int lane) {
			problem.impulse[point] = { at.pn[lane], rough(pairs[k].model) ? static_cast<const RoundBlock&>(at).pt[lane] : 0 };
		});
	});
	for (const OverflowPoint& c : overflow_)
		problem.impulse[c.point] = c.p;
	storeVelocity(problem, problem.velocity);
	if (problem.stretches()) problem.setStretch(stretch_);
}

void PackedProblem::storeVelocity(const ContactProblem& problem, std::vector<Twist>& velocity)
{
	followImpulses();
	velocity.resize(problem.freeVelocity.size());
	team.forEach(inverseGyration_.size(), [&](int i) {
		const int record = layout_.record(i);
		velocity[i]      = problem.freeVelocity[i];
		velocity[i].x    = view().halfBody(record).x;
		velocity[i].y    = view().halfBody(record).y;
		if (!layout_.central(i) && problem.inverseMass[i].rotation > 0) velocity[i].rotation = view().wholeBody(record).spin * inverseGyration_[i];
	});
}

ModelSummary PackedProblem::summary() const
{
	ModelSummary s = layout_.summary();
	s.layouts      = layouts_;
	return s;
}

} // namespace rcr

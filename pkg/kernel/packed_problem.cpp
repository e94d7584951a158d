#include "packed_problem.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace rcr {

namespace {

	constexpr int    bodiesAtATime   = 512;  // that a thread takes at a time
	constexpr double blockedGyration = 1e30; // of a body that cannot turn: no impulse turns it, and the square is finite

	double inverseGyration(const InverseMass& m)
	{
		if (m.x != m.y || m.x <= 0) return 1; // prescribed or special: any scale will do
		return m.rotation > 0 ? std::sqrt(m.rotation / m.x) : 1 / blockedGyration;
	}

	Impulse operator+(Impulse a, Impulse b) { return { a.n + b.n, a.t + b.t }; }
	Impulse operator-(Impulse a, Impulse b) { return { a.n - b.n, a.t - b.t }; }
	Impulse operator*(double s, Impulse a) { return { s * a.n, s * a.t }; }
	double  square(Impulse a) { return a.n * a.n + a.t * a.t; }

	Measures sum(const Measures& a, const Measures& b)
	{
		return { a.error2 + b.error2,         a.impulse2 + b.impulse2,   a.normal + b.normal,
			 a.violation2 + b.violation2, a.velocity2 + b.velocity2, a.stopping2 + b.stopping2 };
	}

} // namespace

// ---- the problem in

void PackedProblem::load(const ContactProblem& problem, int lanes)
{
	kernels_ = &packedKernels(lanes);
	const auto start = std::chrono::steady_clock::now();
	const bool fresh = layout_.update(problem);
	layoutSeconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	if (fresh) {
		++layouts_;
		point_.resize(layout_.pointBlocks());
		for (int block : layout_.vacantBlocks())
			point_[block] = {};
		body_.assign(layout_.records(), {});
	}
	partial_.resize(layout_.chunks().size());
	sum_.resize(layout_.chunks().size());

	const std::vector<Pair>& pairs = layout_.pairs();
	inverseGyration_.resize(problem.inverseMass.size());
	team.forEach(problem.inverseMass.size(), [&](int i) {
		inverseGyration_[i] = inverseGyration(problem.inverseMass[i]);
		body_[i]            = freeRecord(problem, i);
	});
	team.forEach(pairs.size(), [&](int k) {
		if (pairs[k].slot != Pair::outside) fill(problem, pairs[k]);
	});
	tail_.clear();
	for (const Pair& pair : pairs)
		if (pair.slot == Pair::outside) addToTail(problem, pair);

	team.share(0, int(sum_.size()), [&, v = view()](int k) { sum_[k] = kernels_->prepare(v, layout_.chunks()[k]); });
	freeVelocity2_ = std::accumulate(sum_.begin(), sum_.end(), 0.0);
	for (const TailPoint& c : tail_)
		freeVelocity2_ += square(relativeVelocity(c));
	applyImpulses();
	oldBody_ = body_;
}

BodyRecord PackedProblem::freeRecord(const ContactProblem& problem, int body) const
{
	const Twist& v       = problem.freeVelocity[body];
	const bool   regular = layout_.kind(body) == BodyKind::regular;
	return { v.x, v.y, v.rotation / inverseGyration_[body], regular ? problem.inverseMass[body].x : 0 };
}

void PackedProblem::fill(const ContactProblem& problem, const Pair& pair)
{
	const int        lane = pair.slot % blockWidth;
	const PairBlock& home = layout_.pairBlocks()[pair.slot / blockWidth];
	if (home.body1[lane] != offsetOf(pair.body1)) recordAt(body_.data(), home.body1[lane]) = body_[pair.body1]; // a prescribed side
	if (home.body2[lane] != offsetOf(pair.body2)) recordAt(body_.data(), home.body2[lane]) = body_[pair.body2];
	const double scale1 = inverseGyration_[pair.body1], scale2 = inverseGyration_[pair.body2];
	for (int i = 0; i < pair.points; ++i) {
		const ContactPoint& c = problem.points[pair.firstPoint + i];
		const Impulse&      p = problem.impulse[pair.firstPoint + i];
		PointBlock&         k = point_[pair.pointBlock + i];
		k.nx[lane]            = c.normal.x;
		k.ny[lane]            = c.normal.y;
		k.turn1n[lane]        = c.arm1.x * scale1;
		k.turn1t[lane]        = c.arm1.y * scale1;
		k.turn2n[lane]        = c.arm2.x * scale2;
		k.turn2t[lane]        = c.arm2.y * scale2;
		k.bias[lane]          = c.bias;
		k.friction[lane]      = c.friction;
		k.pn[lane] = k.oldPn[lane] = p.n;
		k.pt[lane] = k.oldPt[lane] = p.t;
	}
}

void PackedProblem::addToTail(const ContactProblem& problem, const Pair& pair)
{
	const double scale1 = inverseGyration_[pair.body1], scale2 = inverseGyration_[pair.body2];
	for (int k = pair.firstPoint; k < pair.firstPoint + pair.points; ++k) {
		const ContactPoint& c = problem.points[k];
		const InverseMass & m1 = problem.inverseMass[c.body1], &m2 = problem.inverseMass[c.body2];
		const Delassus      w  = delassus(c, m1, m2);
		if (w.nn <= 0) continue;
		const Vec2 t = perp(c.normal);
		tail_.push_back({ c.body1, c.body2, k, c.normal,
		                  cross(c.arm1, c.normal) * scale1, cross(c.arm1, t) * scale1,
		                  cross(c.arm2, c.normal) * scale2, cross(c.arm2, t) * scale2,
		                  { m1.x, m1.y, m1.rotation / (scale1 * scale1) }, { m2.x, m2.y, m2.rotation / (scale2 * scale2) },
		                  c.bias, c.friction, w, problem.impulse[k], problem.impulse[k] });
	}
}

// ---- points outside the colours

Impulse PackedProblem::relativeVelocity(const TailPoint& c) const
{
	const BodyRecord &v1 = body_[c.body1], &v2 = body_[c.body2];
	const Vec2        u { v2.x - v1.x, v2.y - v1.y };
	return { dot(u, c.normal) + v2.spin * c.turn2n - v1.spin * c.turn1n, dot(u, perp(c.normal)) + v2.spin * c.turn2t - v1.spin * c.turn1t };
}

void PackedProblem::applyImpulse(const TailPoint& c, const Impulse& p)
{
	BodyRecord &v1 = body_[c.body1], &v2 = body_[c.body2];
	const Vec2  f = p.n * c.normal + p.t * perp(c.normal);
	v1.x -= c.mass1.x * f.x;
	v1.y -= c.mass1.y * f.y;
	v1.spin -= c.mass1.rotation * (p.n * c.turn1n + p.t * c.turn1t);
	v2.x += c.mass2.x * f.x;
	v2.y += c.mass2.y * f.y;
	v2.spin += c.mass2.rotation * (p.n * c.turn2n + p.t * c.turn2t);
}

/// The impulse that solves the point while all others stay; `p` is what the velocities hold of it.
Impulse PackedProblem::solve(const TailPoint& c, const Impulse& p) const
{
	const Impulse u = relativeVelocity(c);
	return solveCoulomb(c.w, u.n + c.bias - c.w.nn * p.n - c.w.nt * p.t, u.t - c.w.nt * p.n - c.w.tt * p.t, c.friction);
}

// ---- the steps of the solvers

void PackedProblem::applyImpulses()
{
	byColor([&, v = view()](int k) { kernels_->apply(v, layout_.chunks()[k]); });
	for (const TailPoint& c : tail_)
		applyImpulse(c, c.p);
}

void PackedProblem::sweep()
{
	byColor([&, v = view()](int k) { kernels_->sweep(v, layout_.chunks()[k]); });
	for (TailPoint& c : tail_) {
		const Impulse next = solve(c, c.p);
		applyImpulse(c, next - c.p);
		c.p = next;
	}
}

void PackedProblem::sweepRelaxed(double relaxation)
{
	byColor([&, v = view()](int k) { kernels_->sweepRelaxed(v, layout_.chunks()[k], relaxation); });
	for (TailPoint& c : tail_) {
		const Impulse next = projectCone(c.p + relaxation * (solve(c, c.p) - c.p), c.friction);
		applyImpulse(c, next - c.p);
		c.p = next;
	}
}

double PackedProblem::sweepMomentum(double momentum)
{
	byColor([&, v = view()](int k) { sum_[k] = kernels_->sweepMomentum(v, layout_.chunks()[k], momentum); });
	double change2 = std::accumulate(sum_.begin(), sum_.end(), 0.0);
	for (TailPoint& c : tail_) {
		const Impulse from = c.p + momentum * (c.p - c.old), next = solve(c, from);
		applyImpulse(c, next - from);
		c.old = c.p;
		c.p   = next;
		change2 += square(next - from);
	}
	return change2;
}

void PackedProblem::extrapolate(double momentum)
{
	const int bodies = int(inverseGyration_.size());
	team.share(0, (bodies + bodiesAtATime - 1) / bodiesAtATime, [&, v = view()](int part) {
		kernels_->extrapolate(v, part * bodiesAtATime, std::min(bodies, (part + 1) * bodiesAtATime), momentum);
	});
	body_.swap(oldBody_);
}

Measures PackedProblem::measure()
{
	team.share(0, int(partial_.size()), [&, v = view()](int k) { partial_[k] = kernels_->measure(v, layout_.chunks()[k]); });
	Measures total = std::accumulate(partial_.begin(), partial_.end(), Measures {}, sum);
	for (const TailPoint& c : tail_) {
		const Impulse u = relativeVelocity(c);
		const double  un = u.n + c.bias;
		const double  stopping = (std::abs(u.n) + std::abs(c.bias)) / c.w.nn;
		const Impulse q = projectCone({ c.p.n - (un + c.friction * std::abs(u.t)) / c.w.nn, c.p.t - u.t / c.w.nn }, c.friction);
		const double  miss = square(c.p - q);
		total              = sum(total, { miss, square(c.p), c.p.n, c.w.nn * c.w.nn * miss, square(u), stopping * stopping });
	}
	return total;
}

// ---- the solution out

void PackedProblem::store(ContactProblem& problem)
{
	const std::vector<Pair>& pairs = layout_.pairs();
	team.forEach(pairs.size(), [&](int k) {
		const Pair& pair = pairs[k];
		for (int i = 0; i < pair.points; ++i) {
			Impulse& p = problem.impulse[pair.firstPoint + i];
			if (pair.slot == Pair::outside) p = {};
			else {
				const PointBlock& c = point_[pair.pointBlock + i];
				p                   = { c.pn[pair.slot % blockWidth], c.pt[pair.slot % blockWidth] };
			}
		}
	});
	for (const TailPoint& c : tail_)
		problem.impulse[c.point] = c.p;

	team.forEach(inverseGyration_.size(), [&](int i) { body_[i] = freeRecord(problem, i); });
	applyImpulses();
	problem.velocity.resize(problem.freeVelocity.size());
	team.forEach(inverseGyration_.size(), [&](int i) {
		const bool turns    = problem.inverseMass[i].rotation > 0;
		problem.velocity[i] = { body_[i].x, body_[i].y, turns ? body_[i].spin * inverseGyration_[i] : problem.freeVelocity[i].rotation };
	});
}

} // namespace rcr

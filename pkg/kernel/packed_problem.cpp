#include "packed_problem.hpp"

#include <algorithm>
#include <cmath>

namespace rcr {

namespace {

	constexpr int    itemsAtATime    = 512;  // pairs or bodies that a thread takes at a time
	constexpr double blockedGyration = 1e30; // of a body that cannot turn: no impulse turns it, and the square is finite

	/// Calls work(i) for 0 ≤ i < count, shared among the team.
	template <class Work> void forEach(Team& team, std::size_t count, Work work)
	{
		const int size = int(count);
		team.share(0, (size + itemsAtATime - 1) / itemsAtATime, [&](int part) {
			for (int i = part * itemsAtATime; i < std::min(size, (part + 1) * itemsAtATime); ++i)
				work(i);
		});
	}

	double inverseGyration(const InverseMass& m)
	{
		if (m.x != m.y || m.x <= 0) return 1; // prescribed or special: any scale will do
		return m.rotation > 0 ? std::sqrt(m.rotation / m.x) : 1 / blockedGyration;
	}

	Measures operator+(const Measures& a, const Measures& b)
	{
		return { a.error2 + b.error2, a.impulse2 + b.impulse2, a.normal + b.normal, a.violation2 + b.violation2, a.velocity2 + b.velocity2 };
	}

} // namespace

// ---- the problem in and out

void PackedProblem::load(const ContactProblem& problem, int lanes)
{
	kernels_ = &packedKernels(lanes);
	if (layout_.update(problem)) {
		++layouts_;
		point_.assign(layout_.pointBlocks(), PointBlock {});
		body_.assign(layout_.records(), BodyRecord {});
	}
	point_.resize(layout_.pointBlocks());
	body_.resize(layout_.records());
	step2_.resize(layout_.chunks().size());
	partial_.resize(layout_.chunks().size());
	for (int slot : layout_.vacated())
		clear(slot);
	fillBodies(problem);
	forEach(team, layout_.pairs().size(), [&](int k) { fillPair(problem, layout_.pairs()[k]); });
	tail_.clear();
	for (const Pair& pair : layout_.pairs())
		if (pair.slot == Pair::outside) addToTail(problem, pair);

	const PackedView v = view();
	team.share(0, int(partial_.size()), [&](int k) { step2_[k] = kernels_->prepare(v, layout_.chunks()[k]); });
	freeVelocity2_ = 0;
	for (double part : step2_)
		freeVelocity2_ += part;
	for (const TailPoint& c : tail_) {
		const Impulse u = relativeVelocity(c);
		freeVelocity2_ += u.n * u.n + u.t * u.t;
	}
	applyImpulses();
	oldBody_ = body_;
}

} // namespace rcr

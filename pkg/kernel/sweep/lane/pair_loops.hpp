// Loops over the pairs of a chunk, RCR_LANES pairs at a time, and whole records of their bodies.
// Compiled like lane.hpp.
#pragma once

#include "sweep/lane/rolling_model.hpp"

// Lambdas of inner loops: a call costs a tenth of a point.
#define INLINE __attribute__((always_inline))
// One loop per function: several loops together exhaust the registers.
#define NOINLINE __attribute__((noinline))

namespace rcr::RCR_LANE_NAMESPACE {

namespace {

	/// Calls work(model) for the model of the chunk.
	template <class Work> inline void withModel(const Chunk& chunk, Work work)
	{
		switch (chunk.model) {
			case Model::rolling: return work(Rolling());
			case Model::frictional: return work(Frictional());
			case Model::noLever: return work(NoLever());
			case Model::frictionless: return work(Frictionless());
			case Model::frictionlessDisc: return work(FrictionlessDisc());
		}
	}

	// ---- the loops

	/// Point i of those at `first`.
	template <class Columns> inline Columns pointAt(const Columns& first, int i)
	{
		return Columns(first.first() + i * Columns::count);
	}

	/// Calls visit(bodies 1, bodies 2, first point, lane) for all pairs, RCR_LANES at a time.
	template <class M, class Visit>
	inline void forEachPair(const PackedView& view, const Chunk& chunk, Visit visit)
	{
		const typename M::Columns point(view.points + chunk.firstColumn);
		for (int b = 0; b < chunk.blocks; ++b) {
			const PairBlock& pairs = view.pairs[chunk.firstBlock + b];
			for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
				visit(P { view.body, pairs.body1 + lane }, P { view.body, pairs.body2 + lane },
				        pointAt(point, b * chunk.pointsPerPair), lane);
		}
	}

	// Whole bodies; those of frictionless discs have no spin.

	struct WholePair {
		B v1, v2;
	};

	template <class M>
	INLINE inline WholePair loadWhole(
	        const typename M::Columns& c, int lane, const P& at1, const P& at2)
	{
		const auto v1 = M::load(at1), v2 = M::load(at2);
		if constexpr (std::is_same_v<M, FrictionlessDisc>)
			return { { v1.x, v1.y, L(0.0), L::load(c.inverseMass1() + lane) },
				{ v2.x, v2.y, L(0.0), L::load(c.inverseMass2() + lane) } };
		else
			return { v1, v2 };
	}

	template <class M> INLINE inline void storeWhole(const B& v, const P& at)
	{
		if constexpr (std::is_same_v<M, FrictionlessDisc>) M::store({ v.x, v.y }, at);
		else
			M::store(v, at);
	}

	/// Calls visit(point, lane, v1, v2) for all points of a chunk, RCR_LANES at a time.
	template <class Visit>
	inline void forEachPoint(const PackedView& view, const Chunk& chunk, Visit visit)
	{
		withModel(chunk, [&](auto model) {
			using M = decltype(model);
			forEachPair<M>(view, chunk,
			        [&](const P& at1, const P& at2, const auto& point, int lane) INLINE {
				        const auto [v1, v2] = loadWhole<M>(point, lane, at1, at2);
				        for (int i = 0; i < chunk.pointsPerPair; ++i)
					        visit(pointAt(point, i), lane, v1, v2);
			        });
		});
	}

	/// The velocity (u_n, u_t) of the stop criteria.
	template <class Columns>
	inline Vector wholeVelocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		const Vector u = relativeVelocity(c, lane, v1, v2);
		return { u.n, u.t + L::load(c.tangentialBias() + lane) };
	}

} // namespace
} // namespace rcr::RCR_LANE_NAMESPACE

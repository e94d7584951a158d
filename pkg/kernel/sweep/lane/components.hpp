// Components (n, t), the friction cone and sums of N contact points. Compiled like lane.hpp.
#pragma once

#include "sweep/lane/lane.hpp"

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	template <int N> struct Components {
		Lane<N> n, t;

		friend Components operator+(Components a, Components b) { return { a.n + b.n, a.t + b.t }; }
		friend Components operator-(Components a, Components b) { return { a.n - b.n, a.t - b.t }; }
		friend Components operator*(Lane<N> s, Components a) { return { s * a.n, s * a.t }; }
		friend Components addProduct(Components a, Lane<N> s, Components b)
		{
			return { addProduct(a.n, s, b.n), addProduct(a.t, s, b.t) };
		}
		friend Lane<N> square(Components a) { return addProduct(a.n * a.n, a.t, a.t); }
	};

	/// Projects onto the cone |t| ≤ µ n (problem/coulomb.hpp).
	template <int N> inline Components<N> projectCone(const Components<N>& p, Lane<N> friction)
	{
		using L         = Lane<N>;
		const L    size = abs(p.t), n = (p.n + friction * size) / (L(1.0) + friction * friction);
		const auto inside = size <= friction * p.n, polar = friction * size <= L(0.0) - p.n;
		return { zeroWhere(polar, select(inside, p.n, n)),
			zeroWhere(polar, select(inside, p.t, copySign(friction * n, p.t))) };
	}

	/// One sum per slot: the order of additions does not depend on the lane width.
	template <int W> struct SlotSum {
		alignas(64) Real slot[W] = {};

		template <int N> void add(int lane, Lane<N> value)
		{
			(Lane<N>::load(slot + lane) + value).store(slot + lane);
		}
		double total() const
		{
			double sum = 0;
			for (Real part : slot)
				sum += part;
			return sum;
		}
	};

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr

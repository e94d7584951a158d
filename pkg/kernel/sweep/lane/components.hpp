// Components (n, t), friction cone and sums of RCR_LANES contact points. Compiled like lane.hpp.
#pragma once

#include "sweep/lane/lane.hpp"
#include "sweep/lane/packed_blocks.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

using L = Lane<RCR_LANES>;

struct Vector {
	L n, t;

	friend Vector operator+(Vector a, Vector b) { return { a.n + b.n, a.t + b.t }; }
	friend Vector operator-(Vector a, Vector b) { return { a.n - b.n, a.t - b.t }; }
	friend Vector operator*(L s, Vector a) { return { s * a.n, s * a.t }; }
	friend Vector addProduct(Vector a, L s, Vector b)
	{
		return { addProduct(a.n, s, b.n), addProduct(a.t, s, b.t) };
	}
	friend L square(Vector a) { return addProduct(a.n * a.n, a.t, a.t); }
};

/// Projects onto the cone |t| ≤ µ n (problem/coulomb.hpp).
inline Vector projectCone(const Vector& p, L friction)
{
	const L    size = abs(p.t), n = (p.n + friction * size) / (L(1.0) + friction * friction);
	const auto inside = size <= friction * p.n, polar = friction * size <= L(0.0) - p.n;
	return { zeroWhere(polar, select(inside, p.n, n)),
		zeroWhere(polar, select(inside, p.t, copySign(friction * n, p.t))) };
}

/// One sum per slot: the order of additions does not depend on the lane width.
struct Sum {
	alignas(64) Real slot[blockWidth] = {};

	void add(int lane, L value) { (L::load(slot + lane) + value).store(slot + lane); }
	double total() const
	{
		double sum = 0;
		for (Real part : slot)
			sum += part;
		return sum;
	}
};

} // namespace rcr::RCR_LANE_NAMESPACE

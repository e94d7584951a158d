#include "exact/proximal_problem.hpp"

#include <algorithm>

#include "problem/coulomb.hpp"

namespace rcr {

/// Row of Ĵ of one body: direction d, lever arm, sign −1 for body 1 and +1 for body 2.
static BlockVector scaledRow(Vec2 d, Vec2 arm, const InverseMass& m, double sign)
{
	return { { sign * d.x * std::sqrt(m.x), sign * d.y * std::sqrt(m.y),
		    sign * cross(arm, d) * std::sqrt(m.rotation), 0 } };
}

/// The contact points with w_nn > 0.
static std::vector<ScaledContact> scaledContacts(
        const ContactProblem& problem, std::vector<std::size_t>& origin)
{
	std::vector<ScaledContact> contacts;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c  = problem.points[k];
		const InverseMass&  m1 = problem.inverseMass[c.body1];
		const InverseMass&  m2 = problem.inverseMass[c.body2];
		const Delassus      w  = delassus(c, m1, m2);
		if (w.nn <= 0) continue;
		const Vec2   n = c.normal, t = perp(n);
		const double turn = c.rolls() ? c.rollingLength : 0;
		contacts.push_back({ c.body1, c.body2, scaledRow(n, c.arm1, m1, -1),
		        scaledRow(t, c.arm1, m1, -1), scaledRow(n, c.arm2, m2, 1),
		        scaledRow(t, c.arm2, m2, 1), -turn * std::sqrt(m1.rotation),
		        turn * std::sqrt(m2.rotation), { 0, c.friction, c.rollingFriction }, c.bias, w.nn,
		        m1.prescribed() || m2.prescribed() ? -1 : 0, c.body1 > c.body2 });
		origin.push_back(k);
	}
	return contacts;
}

/// Pairs of bodies that share contacts, each once. Sets ScaledContact::pair.
static std::vector<BlockLu::Pair> findPairs(std::vector<ScaledContact>& contacts)
{
	std::vector<BlockLu::Pair> pairs;
	const auto                 pairOf = [](const ScaledContact& c) {
            return BlockLu::Pair { std::min(c.body1, c.body2), std::max(c.body1, c.body2) };
	};
	for (const ScaledContact& c : contacts)
		if (c.pair >= 0) pairs.push_back(pairOf(c));
	std::sort(pairs.begin(), pairs.end());
	pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
	for (ScaledContact& c : contacts)
		if (c.pair >= 0)
			c.pair = static_cast<std::int32_t>(
			        std::lower_bound(pairs.begin(), pairs.end(), pairOf(c)) - pairs.begin());
	return pairs;
}

/// Impulse of the law for a predictor.
static RowValues lawOf(RowValues predictor, const RowValues& friction)
{
	if (predictor.n <= 0) return {};
	for (const FrictionRow row : frictionRows)
		predictor.*row = clampTo(predictor.*row, friction.*row * predictor.n);
	return predictor;
}

/// block += x yᵀ
static void addProduct(Block& block, const BlockVector& x, const BlockVector& y)
{
	for (int j = 0; j < 3; ++j)
		for (int i = 0; i < 4; ++i)
			block.entry[j][i] += x.entry[i] * y.entry[j];
}

/// k (a + factor b)
static BlockVector scaledSum(const BlockVector& a, const BlockVector& b, double factor, double k)
{
	BlockVector sum;
	for (int i = 0; i < 3; ++i)
		sum.entry[i] = k * (a.entry[i] + factor * b.entry[i]);
	return sum;
}

/// Rows of the stretch rates: u changes by δg ∘ the stretch arm.
static CellRows cellRowsOf(const ContactProblem& problem, const ContactPoint& c)
{
	const Vec2 inverse = problem.inverseStretchMass;
	const Vec2 arm     = componentwise(
                problem.stretchArm(c), { std::sqrt(inverse.x), std::sqrt(inverse.y) });
	const Vec2 n = componentwise(c.normal, arm), t = componentwise(perp(c.normal), arm);
	return { { { n.x, n.y, 0, 0 } }, { { t.x, t.y, 0, 0 } } };
}

ProximalProblem::ProximalProblem(const ContactProblem& problem)
        : bodyCount_(problem.inverseMass.size() + problem.stretches())
{
	contacts                         = scaledContacts(problem, origin_);
	std::vector<BlockLu::Pair> pairs = findPairs(contacts);
	if (problem.stretches()) {
		cellPair_.assign(bodyCount_, -1);
		const auto connect = [&](std::int32_t body) {
			if (cellPair_[body] >= 0 || problem.prescribed(body)) return;
			cellPair_[body] = static_cast<std::int32_t>(pairs.size());
			pairs.push_back({ body, static_cast<std::int32_t>(bodyCount_ - 1) });
		};
		for (std::size_t i = 0; i < contacts.size(); ++i) {
			cellRows.push_back(cellRowsOf(problem, problem.points[origin_[i]]));
			connect(contacts[i].body1);
			connect(contacts[i].body2);
		}
	}
	matrix = BlockLu(static_cast<int>(bodyCount_), pairs);
	stiffness.resize(size());
	pieces.resize(size());
	reference.resize(size());
	referenceVelocity.resize(size());
	predictor.resize(size());
}

void ProximalProblem::setReference(ContactProblem& problem)
{
	updateVelocity(problem);
	for (std::size_t i = 0; i < size(); ++i) {
		const std::size_t   k = origin_[i];
		const ContactPoint& c = problem.points[k];
		const LocalVector   u = rcr::relativeVelocity(problem, c), p = problem.impulse[k];
		referenceVelocity[i] = { u.n + contacts[i].bias, u.t, rollingVelocity(problem, c) };
		reference[i]         = { p.n, p.t, problem.rollingImpulseOf(k) };
	}
}

bool ProximalProblem::factor()
{
	matrix.setIdentity();
	for (std::size_t i = 0; i < size(); ++i) {
		if (!pieces[i].closed) continue;
		const ScaledContact& c = contacts[i];
		const auto add = [&](const BlockVector& x1, const BlockVector& x2, const BlockVector& y1,
		                         const BlockVector& y2) {
			addProduct(matrix.diagonal(c.body1), x1, y1);
			addProduct(matrix.diagonal(c.body2), x2, y2);
			if (c.pair < 0) return;
			addProduct(matrix.pairBlock(c.pair, c.flipped), x1, y2);
			addProduct(matrix.pairBlock(c.pair, !c.flipped), x2, y1);
		};
		// impulse per unit of normal velocity: n + s µ t + s_r µ_r r; s = 0 if a row sticks
		const double k = stiffness[i], side = pieces[i].slides.t * c.friction.t,
		             spin    = k * pieces[i].slides.r * c.friction.r;
		BlockVector  normal1 = scaledSum(c.normal1, c.tangent1, side, k),
		             normal2 = scaledSum(c.normal2, c.tangent2, side, k);
		normal1.entry[2] += spin * c.turn1;
		normal2.entry[2] += spin * c.turn2;
		const BlockVector tangent1 = scaledSum(c.tangent1, c.normal1, 0, k),
		                  tangent2 = scaledSum(c.tangent2, c.normal2, 0, k);
		const bool        sticks   = pieces[i].sticks[0];
		add(normal1, normal2, c.normal1, c.normal2);
		if (sticks) add(tangent1, tangent2, c.tangent1, c.tangent2);
		if (pieces[i].sticks[1])
			add({ { 0, 0, k * c.turn1 } }, { { 0, 0, k * c.turn2 } }, { { 0, 0, c.turn1 } },
			        { { 0, 0, c.turn2 } });
		if (cellRows.empty()) continue;
		const CellRows& cell = cellRows[i];
		addCellBlocks(i, normal1, normal2, scaledSum(cell.normal, cell.tangent, side, k), c.normal1,
		        c.normal2, cell.normal);
		if (sticks)
			addCellBlocks(i, tangent1, tangent2, scaledSum(cell.tangent, cell.normal, 0, k),
			        c.tangent1, c.tangent2, cell.tangent);
	}
	return matrix.factor();
}

/// Adds x yᵀ to the blocks of the cell, where x and y have parts of body 1, body 2 and the cell.
void ProximalProblem::addCellBlocks(std::size_t contact, const BlockVector& x1,
        const BlockVector& x2, const BlockVector& xc, const BlockVector& y1, const BlockVector& y2,
        const BlockVector& yc)
{
	const auto couple = [&](std::int32_t body, const BlockVector& x, const BlockVector& y) {
		if (cellPair_[body] < 0) return;
		addProduct(matrix.pairBlock(cellPair_[body], false), x, yc);
		addProduct(matrix.pairBlock(cellPair_[body], true), xc, y);
	};
	couple(contacts[contact].body1, x1, y1);
	couple(contacts[contact].body2, x2, y2);
	addProduct(matrix.diagonal(static_cast<std::int32_t>(bodyCount_ - 1)), xc, yc);
}

void ProximalProblem::store(ContactProblem& problem) const
{
	for (std::size_t i = 0; i < size(); ++i) {
		const RowValues p           = lawOf(predictor[i], contacts[i].friction);
		problem.impulse[origin_[i]] = p.local();
		if (contacts[i].friction.r > 0) problem.rollingImpulse[origin_[i]] = p.r;
	}
}

} // namespace rcr

#include "delassus/piece_steps.hpp"

#include <algorithm>
#include <cmath>

namespace rcr {

namespace {

	constexpr int maxNewton = 6; // steps; beyond, it cycles

	PieceMap pieceAt(Impulse predictor, double friction)
	{
		if (predictor.n <= 0) return {};
		if (std::abs(predictor.t) <= friction * predictor.n) return { 1, 1, 0 };
		return { 1, 0, std::copysign(friction, predictor.t) };
	}

	/// Pairs of points with a block of W, each once, and the pair of every block off the diagonal.
	std::vector<BlockLu::Pair> findPairs(const DelassusProblem& problem, std::vector<std::int32_t>& pairOf)
	{
		std::vector<BlockLu::Pair> pairs;
		std::vector<std::int32_t>  next(problem.free.size()); // a row above: its next pair
		pairOf.resize(problem.column.size());
		for (std::int32_t k = 0; k < std::int32_t(problem.free.size()); ++k) {
			next[k] = std::int32_t(pairs.size());
			for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
				const std::int32_t j = problem.column[e];
				if (j < k) pairOf[e] = next[j]++;
				if (j <= k) continue;
				pairOf[e] = std::int32_t(pairs.size());
				pairs.emplace_back(k, j);
			}
		}
		return pairs;
	}

} // namespace

PieceSteps::PieceSteps(DelassusProblem& problem)
        : problem_(problem)
        , inverseNn_(problem.free.size())
        , matrix_(std::int32_t(problem.free.size()), findPairs(problem, pairOf_))
        , pieces_(problem.free.size())
        , change_(problem.free.size())
{
	for (std::size_t k = 0; k < problem.free.size(); ++k)
		for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e)
			if (problem.column[e] == std::int32_t(k) && problem.block[e].nn > 0) inverseNn_[k] = 1 / problem.block[e].nn;
}

bool PieceSteps::step(double rho, int& iterations, int maxIterations)
{
	std::fill(change_.begin(), change_.end(), Impulse {});
	updatePieces(rho);
	for (int i = 0; i < maxNewton && iterations < maxIterations; ++i) {
		++iterations;
		if (!solvePieces(rho)) return false;
		if (updatePieces(rho)) continue;
		std::vector<Impulse> found(pieces_.size());
		for (std::size_t k = 0; k < pieces_.size(); ++k)
			found[k] = pieces_[k] * predictor(k, rho);
		problem_.impulse.swap(found);
		return true;
	}
	return false;
}

/// π
Impulse PieceSteps::predictor(std::size_t k, double rho) const
{
	Impulse u = problem_.velocity[k];
	for (std::int32_t e = problem_.rowStart[k]; e < problem_.rowStart[k + 1]; ++e)
		u = u + problem_.block[e] * change_[problem_.column[e]];
	return problem_.impulse[k] - stiffness(k, rho) * u;
}

/// True if a piece is another than before.
bool PieceSteps::updatePieces(double rho)
{
	bool changed = false;
	for (std::size_t k = 0; k < pieces_.size(); ++k) {
		const PieceMap piece = inverseNn_[k] > 0 ? pieceAt(predictor(k, rho), problem_.friction[k]) : PieceMap {};
		changed |= !(piece == pieces_[k]);
		pieces_[k] = piece;
	}
	return changed;
}

/// d on the present pieces.
bool PieceSteps::solvePieces(double rho)
{
	std::vector<BlockVector> right(pieces_.size());
	matrix_.setIdentity();
	for (std::size_t k = 0; k < pieces_.size(); ++k) {
		const PieceMap& piece = pieces_[k];
		const double stiff = stiffness(k, rho);
		for (std::int32_t e = problem_.rowStart[k]; e < problem_.rowStart[k + 1]; ++e) {
			const std::size_t    j     = problem_.column[e];
			Block&               place = j == k ? matrix_.diagonal(std::int32_t(k)) : matrix_.pairBlock(pairOf_[e], j < k);
			const DelassusBlock& w     = problem_.block[e];
			const Impulse        n = piece * Impulse { stiff * w.nn, stiff * w.tn }, t = piece * Impulse { stiff * w.nt, stiff * w.tt };
			place.entry[0][0] += n.n;
			place.entry[0][1] += n.t;
			place.entry[1][0] += t.n;
			place.entry[1][1] += t.t;
		}
		const Impulse b   = piece * (problem_.impulse[k] - stiff * problem_.velocity[k]) - problem_.impulse[k];
		right[k].entry[0] = b.n;
		right[k].entry[1] = b.t;
	}
	if (!matrix_.factor()) return false;
	matrix_.solve(right);
	for (std::size_t k = 0; k < pieces_.size(); ++k)
		change_[k] = { right[k].entry[0], right[k].entry[1] };
	return true;
}

} // namespace rcr

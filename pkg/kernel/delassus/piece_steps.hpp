// Proximal steps on a problem of W and q, by Newton on the pieces of the contact law.
//
// The step about p_ref is that of proximal_problem.hpp with the impulses themselves as unknowns, d = p − p_ref:
//   π = p_ref − k (u_ref + W d),   k = ρ/w_nn;   on given pieces p = S π, so (1 + S k W) d = S (p_ref − k u_ref) − p_ref
// with S = 0 apart, 1 where it sticks, (n, t) → (n, sµ n) where it slides. Newton goes from the pieces of one π to those of
// the next and has arrived when they are the same.
#pragma once

#include <vector>

#include "exact/block_lu.hpp"
#include "delassus/delassus_problem.hpp"

namespace rcr {

/// S of one point.
struct PieceMap {
	double n = 0, t = 0, side = 0; // p_n = n π_n,  p_t = t π_t + side π_n

	bool    operator==(const PieceMap& o) const { return n == o.n && t == o.t && side == o.side; }
	Impulse operator*(Impulse p) const { return { n * p.n, t * p.t + side * p.n }; }
};

class PieceSteps {
public:
	explicit PieceSteps(DelassusProblem&);

	/// From p_ref and u_ref, impulses and velocities of the problem, to the impulses that solve the step; adds up Newton's steps. False: not arrived.
	bool step(double rho, int& iterations, int maxIterations);

private:
	double  stiffness(std::size_t k, double rho) const { return inverseNn_[k] * rho; }
	Impulse predictor(std::size_t k, double rho) const;
	bool    updatePieces(double rho);
	bool    solvePieces(double rho);

	DelassusProblem&          problem_;
	std::vector<std::int32_t> pairOf_;    // a block of W: its pair in the matrix
	std::vector<double>       inverseNn_; // 0 between two prescribed bodies
	BlockLu                   matrix_;    // 1 + S k W; the third row of each block is idle
	std::vector<PieceMap>     pieces_;
	std::vector<Impulse>      change_;    // d
};

} // namespace rcr

// Solves one proximal problem by following the path of its solution from a problem that the reference solves.
//
//   the contact law between p and u + (p − p_ref)/k + (1 − t) e,   t = 0 … 1
//
// The shift e is the least that makes p_ref itself the solution at t = 0: where it presses without sliding, e = −u. The
// solution is a continuous path in (t, y), straight inside a piece. Each pivot goes to the nearest edge of the present
// piece and changes the piece of one contact there: a change x yᵀ of rank one to the matrix, followed by the
// Sherman–Morrison formula. The pivots are about as many as the contacts whose state must change, and do not depend on
// the stiffness k.
//
// Sliding is not associated, so a pivot can turn the sign of the determinant. There the path folds back to smaller t:
// the solution near p_ref does not exist beyond. The way ends at such a fold.
// Source: Katzenelson 1965; Cottle, Pang and Stone 1992, ch. 4 (parametric pivoting); Eaves 1976 (folds).
#pragma once

#include "exact/proximal_problem.hpp"

namespace rcr {

struct PathEnd {
	bool arrived = false; // at t = 1; otherwise at a fold, or after `maxPivots`
	int  pivots  = 0;

	/// At a fold: the contacts that move in the state that becomes unstable there. None where the way ended otherwise.
	std::vector<std::size_t> unstable;
};

/// Leaves the predictors of the point reached, at t = 1 those of the solution.
PathEnd followPath(ProximalProblem&, int maxPivots);

} // namespace rcr

// Solves a proximal problem by following the path of its solution from a problem whose solution is
// known.
//
//   the contact law between p and u + (p − p_ref)/k + (1 − t) e,   t = 0 … 1
//
// The smallest shift e makes p_ref the solution at t = 0. At sticking contacts e = −u. The solution
// is a continuous path in (t, y), straight inside a piece. Each pivot goes to the nearest edge of
// the present piece and changes the piece of one contact. That changes the matrix by x yᵀ, a
// rank-one update by the Sherman–Morrison formula. The number of pivots is about that of contacts
// whose state changes; it does not depend on the stiffness k.
//
// Sliding is not associated, so a pivot can change the sign of the determinant. The path then folds
// back to smaller t: no solution near p_ref exists beyond. The method stops at such a fold.
// Source: Katzenelson 1965; Cottle, Pang and Stone 1992, ch. 4 (parametric pivoting); Eaves 1976
// (folds).
#pragma once

#include "exact/proximal_problem.hpp"

namespace rcr {

struct PathEnd {
	bool complete = false; // the path has reached t = 1; else a fold, maxPivots or no factors
	int  pivots   = 0;

	/// These contacts dominate the motion without resistance at the fold; empty without a fold.
	std::vector<std::size_t> unstable;
};

/// Sets the predictors of the last point of the path; at t = 1, these give the solution.
PathEnd followPath(ProximalProblem&, int maxPivots);

} // namespace rcr

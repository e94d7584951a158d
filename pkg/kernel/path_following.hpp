// Solves one proximal problem by following the path of its solution from a problem that the reference solves.
//
//   the contact law between p and u + (p − p_ref)/k + (1 − t) e,   t = 0 … 1
//
// The shift e is the least that makes p_ref itself the solution at t = 0: where it presses without sliding, e = −u. The
// solution is a continuous path in (t, y), straight inside a piece. Each pivot goes to the nearest edge of the present
// piece and changes the piece of one contact there: a change x yᵀ of rank one to the matrix, followed by the
// Sherman–Morrison formula. Sliding is not associated, so a pivot can turn the determinant's sign; there the path folds
// back and t decreases for a while. The number of pivots is about the number of contacts whose state must change.
// Source: Katzenelson 1965; Eaves 1976; Cottle, Pang and Stone 1992, ch. 4 (parametric pivoting).
#pragma once

#include "proximal_problem.hpp"

namespace rcr {

struct PathEnd {
	bool   arrived = false; // at t = 1: pieces and predictors of the problem hold the solution
	double reached = 0;     // largest t on the path
	int    pivots  = 0;
	int    folds   = 0;
};

/// Gives up after `maxPivots` or when the path leads away for good.
PathEnd followPath(ProximalProblem&, int maxPivots);

} // namespace rcr

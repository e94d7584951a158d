// The contact problem without bodies: the Delassus matrix of all contact points and their
// velocities.
//
//   u = W p + q,   0 ≤ u_n ⟂ p_n ≥ 0,   |p_t| ≤ µ p_n,   p_t = −µ p_n sign(u_t) where u_t ≠ 0
//
// | symbol | field        | unit | meaning                                                  |
// |--------|--------------|------|----------------------------------------------------------|
// | W      | block        | 1/kg | J M⁻¹ Jᵀ: positive semi-definite, 2×2 blocks in (n, t)    |
// | q      | freeVelocity | m/s  | relative velocity without contact impulses, b_n included |
// | µ      | friction     | –    | Coulomb coefficient                                      |
// | p      | impulse      | N s  | p_n ≥ 0 pushes apart                                     |
// | u      | velocity     | m/s  | u_n > 0 opens the contact                                |
//
// These problems come from files (FCLIB, Siconos). With bodies, contact_problem.hpp is faster.
// Source: Jean 1999; Acary, Brémond and Huber 2018 (FCLIB).
#pragma once

#include "problem/solver.hpp"

namespace rcr {

struct DelassusBlock {
	double nn = 0, nt = 0, tn = 0, tt = 0; // nt: effect of p_t on u_n
};

inline LocalVector operator*(const DelassusBlock& w, LocalVector p)
{
	return { w.nn * p.n + w.nt * p.t, w.tn * p.n + w.tt * p.t };
}

/// W is stored in compressed rows of blocks. Each row holds its diagonal block. Columns ascend in a
/// row. Block (j, k) exists where block (k, j) does; they may differ by rounding.
struct DelassusProblem {
	std::vector<std::int32_t> rowStart; // row k has the blocks rowStart[k] … rowStart[k + 1] − 1
	std::vector<std::int32_t>  column;  // of each block
	std::vector<DelassusBlock> block;
	std::vector<LocalVector>   freeVelocity;
	std::vector<double>        friction;
	std::vector<LocalVector>   impulse;  // in: initial guess; out: solution
	std::vector<LocalVector>   velocity; // out: u of the solution
};

/// Solves the problem with the solver of that name (solve_delassus.cpp).
/// Reads tolerance, maxIterations, minIterations, checkInterval and stallSweeps. Throws
/// std::invalid_argument for an unknown solver, a bad setting or a bad problem: array lengths, the
/// pattern of W, numbers that are not finite, diagonals < 0, friction outside 0 … 1000.
Report solve(DelassusProblem&, const std::string& solver, const Settings&);

} // namespace rcr

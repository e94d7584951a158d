// The contact problem without its bodies: the Delassus matrix of all contact points and their free velocities.
//
//   u = W p + q,   0 ≤ u_n ⟂ p_n ≥ 0,   |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0
//
// | symbol | field    | unit | meaning                                                           |
// |--------|----------|------|-------------------------------------------------------------------|
// | W      | block    | 1/kg | J M⁻¹ Jᵀ: symmetric and positive semi-definite, 2×2 blocks in (n, t) |
// | q      | free     | m/s  | velocity of a point without impulses, b_n included                |
// | µ      | friction | –    | Coulomb coefficient                                               |
// | p      | impulse  | N s  | p_n ≥ 0 pushes apart                                              |
//
// Contact laws and residual are those of contact_problem.hpp and residual.hpp. It serves problems that come in this form
// from elsewhere; with the bodies at hand a sweep costs half as much, and exact steps far less.
// Source: Jean 1999; Acary, Brémond and Huber 2018 (FCLIB).
#pragma once

#include <cstdint>
#include <vector>

#include "problem/solver.hpp"

namespace rcr {

struct DelassusBlock {
	double nn = 0, nt = 0, tn = 0, tt = 0; // nt: what p_t does to u_n
};

inline Impulse operator*(const DelassusBlock& w, Impulse p) { return { w.nn * p.n + w.nt * p.t, w.tn * p.n + w.tt * p.t }; }

struct DelassusProblem {
	std::vector<std::int32_t>  rowStart; // a point: its blocks are rowStart[k] … rowStart[k + 1] − 1
	std::vector<std::int32_t>  column;   // a block: ascending in a row, the diagonal among them; symmetric as a pattern
	std::vector<DelassusBlock> block;
	std::vector<Impulse>       free;
	std::vector<double>        friction;
	std::vector<Impulse>       impulse;  // warm start in, solution out
	std::vector<Impulse>       velocity; // out: u for `impulse`
};

/// The problem of these rows alone, in ascending order; no block may join them to others.
DelassusProblem partOf(const DelassusProblem&, const std::vector<std::int32_t>& rows);

/// Throws std::invalid_argument for arrays of different lengths, columns out of range or order or without their mirror
/// image, a number that is not finite, a negative w_nn, w_tt or friction.
void checkProblem(const DelassusProblem&);

/// Runs the solver of that name, as `solve` does for problems with bodies, on each part that nothing joins to others; exact and
/// auto both sweep first, then take Newton steps where sweeps lead no further. The residual is also measured between two of
/// `checkInterval` where a sweep changed so little that it may do. `threads`, `violation` and `meanForceChange` are not used.
Report solve(DelassusProblem&, const std::string& solver, const Settings&);

} // namespace rcr

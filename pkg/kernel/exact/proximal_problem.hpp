// A proximal step: the contact law softened about a reference, as a piecewise linear map.
//
//   y = Ĵᵀ (p − p_ref),   u = u_ref + b_n n + Ĵ y,   Ĵ = J M^(−1/2)
//   the contact law between p and u + (p − p_ref)/k,   k = ρ/w_nn
//
// y = M^(1/2) (v − v_ref), so the matrix of the problem is I + Ĵᵀ K Ĵ. Ĵ is zero for prescribed
// degrees of freedom. All quantities are increments about the reference: near the solution they and
// their rounding errors are small. With π = p_ref − k u, the law is explicit in pieces:
//
//   apart    π_n ≤ 0           p = 0
//   closed   π_n > 0           p_n = π_n, and for the rows t and r alike
//     stick    |π_t| ≤ µ π_n     p_t = π_t
//     slide    s π_t > µ π_n     p_t = s µ π_n,  s = ±1 (0 if µ = 0)
//
// Row r is rolling resistance, with µ_r in place of µ. A fixed point p = p_ref solves the contact
// problem for any ρ.
//
// | symbol | unit    | meaning                                                  |
// |--------|---------|----------------------------------------------------------|
// | y      | √kg m/s | mass-scaled change of velocity                           |
// | Ĵ      | 1/√kg   | rows of one contact point: n, t, r, on body 1 and body 2 |
// | k      | kg      | stiffness of the proximal term                           |
// | ρ      | –       | proximal parameter k w_nn; ∞: the contact law            |
// | π      | N s     | predictor                                                |
//
// Source: Rockafellar 1976 (proximal point); Alart and Curnier 1991 (the pieces).
#pragma once

#include "exact/block_lu.hpp"
#include "problem/contact_problem.hpp"

namespace rcr {

/// Values of the rows of a contact point: n, and those with friction, t and r.
struct RowValues {
	double n = 0, t = 0, r = 0;

	LocalVector local() const { return { n, t }; }
};

inline RowValues operator+(RowValues a, RowValues b) { return { a.n + b.n, a.t + b.t, a.r + b.r }; }
inline RowValues operator-(RowValues a, RowValues b) { return { a.n - b.n, a.t - b.t, a.r - b.r }; }
inline RowValues operator*(double s, RowValues a) { return { s * a.n, s * a.t, s * a.r }; }
inline double    dot(RowValues a, RowValues b) { return a.n * b.n + a.t * b.t + a.r * b.r; }

/// A row with friction.
using FrictionRow = double RowValues::*;
constexpr FrictionRow frictionRows[] = { &RowValues::t, &RowValues::r };

/// Rows of Ĵ for one contact point, and the parameters of its law.
struct ScaledContact {
	std::int32_t body1, body2;
	BlockVector  normal1, tangent1, normal2, tangent2;
	double       turn1, turn2; // row r: coefficients of the spins
	RowValues    friction;     // µ and µ_r
	double       bias, wnn;
	std::int32_t pair;    // of its bodies in the matrix; −1 if the motion of one is prescribed
	bool         flipped; // body 1 is the second of that pair
};

/// Rows of Ĵ of the stretch rates of a cell, for one contact point.
struct CellRows {
	BlockVector normal, tangent;
};

struct Piece {
	bool      closed = false;
	RowValues slides;         // s of the rows that slide
	bool      sticks[2] = {}; // of each friction row

	bool anySticks() const { return sticks[0] || sticks[1]; }
};

using BodyVector = std::vector<BlockVector>;

inline double dot(const BlockVector& a, const BlockVector& b)
{
	return a.entry[0] * b.entry[0] + a.entry[1] * b.entry[1] + a.entry[2] * b.entry[2];
}

class ProximalProblem {
public:
	explicit ProximalProblem(const ContactProblem&);

	/// Ĵ y of a contact point.
	RowValues relativeVelocity(std::size_t i, const BodyVector& y) const
	{
		const ScaledContact& c = contacts[i];
		const double *       a = y[c.body1].entry, *b = y[c.body2].entry;
		RowValues            u { 0, 0, c.turn1 * a[2] + c.turn2 * b[2] };
		for (int k = 0; k < 3; ++k) {
			u.n += c.normal1.entry[k] * a[k] + c.normal2.entry[k] * b[k];
			u.t += c.tangent1.entry[k] * a[k] + c.tangent2.entry[k] * b[k];
		}
		if (cellRows.empty()) return u;
		return u + RowValues { dot(cellRows[i].normal, y.back()), dot(cellRows[i].tangent, y.back()) };
	}
	/// y ← y + Ĵᵀ p of a contact point.
	void applyImpulse(std::size_t i, RowValues p, BodyVector& y) const
	{
		const ScaledContact& c = contacts[i];
		for (int k = 0; k < 3; ++k) {
			y[c.body1].entry[k] += c.normal1.entry[k] * p.n + c.tangent1.entry[k] * p.t;
			y[c.body2].entry[k] += c.normal2.entry[k] * p.n + c.tangent2.entry[k] * p.t;
		}
		y[c.body1].entry[2] += c.turn1 * p.r;
		y[c.body2].entry[2] += c.turn2 * p.r;
		if (cellRows.empty()) return;
		for (int k = 0; k < 2; ++k)
			y.back().entry[k] += cellRows[i].normal.entry[k] * p.n + cellRows[i].tangent.entry[k] * p.t;
	}

	/// Takes the impulses of the problem as reference, and updates its velocities.
	void setReference(ContactProblem&);

	/// Factors I + Ĵᵀ K Ĵ for the present pieces. Returns false if it is singular.
	bool factor();

	/// Applies the law to the predictors and stores the impulses.
	void store(ContactProblem&) const;

	std::size_t size() const { return contacts.size(); }
	/// Number of bodies. A cell that stretches is the last one.
	std::size_t bodies() const { return bodyCount_; }

	std::vector<ScaledContact> contacts;
	std::vector<CellRows>      cellRows; // empty unless a cell stretches
	std::vector<double>        stiffness; // k
	std::vector<Piece>         pieces;
	std::vector<RowValues>     reference;         // p_ref
	std::vector<RowValues>     referenceVelocity; // u_ref + b_n n
	std::vector<RowValues>     predictor;         // π at the end of the step
	BlockLu                    matrix;

private:
	void addCellBlocks(std::size_t contact, const BlockVector& x1, const BlockVector& x2,
	        const BlockVector& xc, const BlockVector& y1, const BlockVector& y2,
	        const BlockVector& yc);

	std::size_t               bodyCount_;
	std::vector<std::int32_t> cellPair_; // number of the pair of a body and the cell; −1: none
	std::vector<std::size_t> origin_; // number of each contact in the contact problem
};

} // namespace rcr

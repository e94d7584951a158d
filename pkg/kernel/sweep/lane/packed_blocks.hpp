// Memory layout of the packed contact problem, and the kernels that work on it.
//
// A block holds sixteen pairs of bodies that share no free body, so sixteen lanes may solve them at
// once. Sixteen doubles are two AVX-512 registers. The point solution is a long chain of operations,
// and the second register fills the waits of the first. A pair has one or two contact points. An
// empty slot holds zeros, which change nothing.
//
// The sweep solves a pair with the cheapest sufficient model:
//
// | model            | holds for                             | unknowns | numbers of a body |
// |------------------|---------------------------------------|----------|-------------------|
// | rolling          | rolling resistance: one point         | all      | 4                 |
// | frictional       | any pair without                      | p_n, p_t | 4                 |
// | noLever          | discs: no normal has a lever          | p_n, p_t | 4                 |
// | frictionless     | µ = 0                                 | p_n      | 4                 |
// | frictionlessDisc | µ = 0, no lever on the whole island   | p_n      | 2                 |
//
// Cheaper models omit terms that are zero or rounding errors.
//
// Columns and records are doubles, or floats about a reference in doubles (packed_island.hpp).
// Records of floats hold v − v_ref; `bias` holds u_ref,n + b_n, `tangentialBias` u_ref,t. Impulses
// are no differences.
//
// | symbol | column         | unit | meaning                                                 |
// |--------|----------------|------|---------------------------------------------------------|
// | n      | nx, ny         | –    | normal from body 1 to body 2                            |
// | b_n    | bias           | m/s  | added to u_n                                            |
// |        | tangentialBias | m/s  | added to u_t: the part that the records do not hold     |
// | p      | pn, pt         | N s  | impulse; oldPn, oldPt: one sweep before, for momentum   |
// | µ      | friction       | –    | Coulomb coefficient                                     |
// | k      |                | m    | radius of gyration √(I/m) of a body                     |
// | kω     | (record)       | m/s  | scaled spin: its inverse mass is 1/m                    |
// | j      | lever…         | –    | (r × n)/k and (r × t)/k: lever arms of scaled spins     |
// | w      |                | 1/kg | Delassus block of the point                             |
// | 1/w_nn | inverseNn      | kg   | 0 in empty slots                                        |
// | r      | ratio          | –    | w_nt / w_nn                                             |
// | 1/z    | inverseSchur   | kg   | z = w_tt − w_nt²/w_nn                                   |
// | t      | turn…          | –    | ℓ/k: lever arms of rolling resistance                   |
// | w_r    | response…      | 1/kg | u_r that unit impulses p_n and p_t cause                |
// | 1/w_rr | inverseRr      | kg   | p_r that unit u_r needs                                 |
// | d±     | slide…         | –    | µ/(1 ± µ r), largest ±p_t/n₀; unlimited if 1 ± µ r ≤ 0  |
//
// n₀ is the normal impulse without friction (point_models.hpp).
#pragma once

#include <cstdint>

#include "problem/measures.hpp"
#include "problem/yielding.hpp"

namespace rcr {

constexpr int blockWidth = 16;

/// Stands for infinity, but 0 · unlimited = 0.
template <class Real>
constexpr Real unlimited = sizeof(Real) == sizeof(double) ? Real(1e300) : Real(1e30);

enum class Model : std::uint8_t { rolling, frictional, noLever, frictionless, frictionlessDisc };
constexpr int models = 5;

/// Returns true if the points of this model have a tangential impulse.
constexpr bool hasFriction(Model model) { return model <= Model::noLever; }

// ---- records of bodies

// A record holds the velocity of a body as consecutive numbers (v_x, v_y, kω, 1/m). On islands of
// frictionless discs, the half record (v_x, v_y) suffices. Records are counted in halves: record i
// begins at number 2 i, and whole records begin at even i.
namespace record {
	constexpr int x = 0, y = 1, spin = 2, inverseMass = 3; // numbers of a whole record
}

inline std::uint32_t offsetOf(std::int32_t record) { return 2 * std::uint32_t(record); }
inline std::int32_t  recordOf(std::uint32_t offset) { return std::int32_t(offset / 2); }

/// Offsets of two records for each pair of a block. A prescribed body has a separate record in each
/// slot.
struct alignas(64) PairBlock {
	std::uint32_t body1[blockWidth], body2[blockWidth];
};

// ---- columns of contact points

/// One quantity of sixteen contact points.
template <class Real> struct alignas(64) ColumnOf {
	Real of[blockWidth];
};
using Column = ColumnOf<double>;

/// One contact point of each pair of a block, as consecutive columns. These are for all models.
template <class Real> class PointColumnsOf {
public:
	explicit PointColumnsOf(ColumnOf<Real>* first) : first_(first) { }

	Real* oldPn() const { return column(0); }
	Real* nx() const { return column(1); }
	Real* ny() const { return column(2); }
	Real* bias() const { return column(3); }
	Real* inverseNn() const { return column(4); }
	Real* pn() const { return column(5); }
	Real* tangentialBias() const { return column(6); }

	ColumnOf<Real>* first() const { return first_; }

protected:
	Real* column(int number) const { return first_[number].of; }

private:
	ColumnOf<Real>* first_;
};

template <class Real> struct FrictionlessDiscColumnsOf : PointColumnsOf<Real> {
	static constexpr int count = 9;
	using PointColumnsOf<Real>::PointColumnsOf;

	Real* inverseMass1() const { return this->column(7); }
	Real* inverseMass2() const { return this->column(8); }
};

/// Until `prepare`, lever…n and lever…t hold x and y of r/k.
template <class Real> struct FrictionlessColumnsOf : PointColumnsOf<Real> {
	static constexpr int count = 11;
	using PointColumnsOf<Real>::PointColumnsOf;

	Real* lever1n() const { return this->column(7); }
	Real* lever2n() const { return this->column(8); }
	Real* lever1t() const { return this->column(9); }
	Real* lever2t() const { return this->column(10); }
};

template <class Real> struct NoLeverColumnsOf : PointColumnsOf<Real> {
	static constexpr int count = 13;
	using PointColumnsOf<Real>::PointColumnsOf;

	Real* lever1t() const { return this->column(7); }
	Real* lever2t() const { return this->column(8); }
	Real* inverseSchur() const { return this->column(9); }
	Real* pt() const { return this->column(10); }
	Real* oldPt() const { return this->column(11); }
	Real* friction() const { return this->column(12); }
};

/// The levers hold r/k as (x, y) until `prepare`.
template <class Real> struct FrictionalColumnsOf : NoLeverColumnsOf<Real> {
	static constexpr int count = 18;
	using NoLeverColumnsOf<Real>::NoLeverColumnsOf;

	Real* lever1n() const { return this->column(13); }
	Real* lever2n() const { return this->column(14); }
	Real* ratio() const { return this->column(15); }
	Real* slidePlus() const { return this->column(16); }
	Real* slideMinus() const { return this->column(17); }
};

/// Rolling resistance: p_r, one sweep before, and its law.
template <class Real> struct RollingColumnsOf : FrictionalColumnsOf<Real> {
	static constexpr int count = 26;
	using FrictionalColumnsOf<Real>::FrictionalColumnsOf;

	Real* pr() const { return this->column(18); }
	Real* oldPr() const { return this->column(19); }
	Real* rollingFriction() const { return this->column(20); }
	Real* turn1() const { return this->column(21); }
	Real* turn2() const { return this->column(22); }
	Real* responseN() const { return this->column(23); }
	Real* responseT() const { return this->column(24); }
	Real* inverseRr() const { return this->column(25); }
};

/// Number of columns of a contact point.
constexpr int columnsOf(Model model)
{
	constexpr int count[models] { RollingColumnsOf<double>::count,
		FrictionalColumnsOf<double>::count, NoLeverColumnsOf<double>::count,
		FrictionlessColumnsOf<double>::count, FrictionlessDiscColumnsOf<double>::count };
	return count[int(model)];
}

/// The blocks of one colour, one model and one number of points per pair.
struct Chunk {
	std::int32_t firstBlock, blocks, firstColumn, pointsPerPair;
	Model        model;
	std::int32_t firstPointBlock; // among those of all chunks
};

/// The arrays that the kernels work on.
template <class Real> struct PackedViewOf {
	Real*            body;    // records
	Real*            oldBody; // one sweep before, for momentum
	const PairBlock* pairs;
	ColumnOf<Real>*  points;

	Real* recordAt(std::int32_t record) const { return body + offsetOf(record); }
};
using PackedView = PackedViewOf<double>;

/// The kernels of sweeps, in doubles or floats. Each works on one chunk.
template <class Real> struct SweepKernels {
	using View = PackedViewOf<Real>;

	/// Solves every point once and updates the velocities: p ← P_K(p + relaxation (solution − p)).
	void (*sweep)(const View&, const Chunk&, double relaxation);
	/// Sweeps from y = p + β (p − p_old). Returns ‖p − y‖². With a compliance ε > 0, all contacts
	/// take solution/(1 + ε max(1, w₀/w_nn)).
	double (*sweepMomentum)(const View&, const Chunk&, double momentum, const Yielding&);
	/// Sums for the stop criteria at the present impulses and velocities. Floats need `bias`, b_n
	/// of the contact law in one column per point block: their own bias contains u_ref.
	/// `leastResponse` of the energies: see Measures [1/kg].
	Measures (*measure)(
	        const View&, const Chunk&, const ColumnOf<Real>* bias, double leastResponse);
	/// v_old ← v + β (v − v_old) for half records first … last − 1. The caller swaps both arrays.
	void (*extrapolate)(const View&, int first, int last, double momentum);
};

/// All kernels of one lane width.
struct PackedKernels : SweepKernels<double> {
	int width;
	/// Computes levers and Delassus coefficients from the arms r/k. Returns Σ |u|².
	double (*prepare)(const View&, const Chunk&);
	/// v ← v + M⁻¹Jᵀp
	void (*apply)(const View&, const Chunk&);
	/// Writes (u_n + b_n, u_t) to `bias` and `tangentialBias` of the columns of floats.
	void (*updateReference)(const View&, const Chunk&, ColumnOf<float>* points);
};

/// Scalar kernels (`lanes` = 1), AVX2 (4), or the widest of the processor (8, 0). AVX-512 kernels
/// work on all 16 lanes of a block at once.
const PackedKernels&       packedKernels(int lanes);
const SweepKernels<float>& singleKernels(int lanes);

} // namespace rcr

// Memory layout of the packed contact problem, and the kernels that work on it.
//
// Pairs of bodies stand in blocks of sixteen that share no free body, so as many lanes may solve them at once: two AVX-512
// registers, since a point is a long chain of operations and one register alone would wait for it. A pair has one or two
// contact points; both are solved while its bodies are in registers. A slot without a pair holds zeros, which leave
// everything as it is.
//
// A pair is swept by the least model that serves it:
//   frictional     two unknowns a point; its bodies turn
//   round          the same where no normal has a lever, as between discs: u_n and p_t know nothing of each other, w_nt = 0
//   frictionless   µ = 0: one unknown a point, the normal impulse
//   central        the same on an island where no normal has a lever: nothing turns, two numbers a body
// The arithmetic is that of the frictional model without what is zero, so the bits are the same.
//
// Blocks and records are of doubles, or of floats about a reference in doubles (packed_island.hpp): records then hold v − v̄, `bias` and
// `slip` the velocity û of the reference, and impulses are whole.
//
// | symbol | field        | unit    | meaning                                                       |
// |--------|--------------|---------|---------------------------------------------------------------|
// | k      |              | m       | radius of gyration √(I/m) of a body                            |
// | kω     | spin         | m/s     | scaled so that one inverse mass serves all three components    |
// | j      | turn…        | –       | (r × n)/k and (r × t)/k: lever arms in the scaled velocities   |
// | w      |              | 1/kg    | Delassus block of the point                                    |
// | 1/w_nn | inverseNn    | kg      |                                                               |
// | r      | ratio        | –       | w_nt / w_nn                                                   |
// | 1/s    | inverseSchur | kg      | s = w_tt − w_nt²/w_nn                                          |
// | d±     | slide…       | –       | µ/(1 ± µ r), the largest ±p_t/n₀; `unlimited` where 1 ± µ r ≤ 0: any p_t sticks |
#pragma once

#include <cstdint>

namespace rcr {

constexpr int blockWidth = 16;
template <class Real> constexpr Real unlimited = sizeof(Real) == sizeof(double) ? Real(1e300) : Real(1e30); // finite: 0 · unlimited is 0

enum class Model : std::uint8_t { frictional, round, frictionless, central };
constexpr int models = 4;

/// Has its points a tangential impulse?
constexpr bool rough(Model model) { return model <= Model::round; }

/// The record of a body's velocity; an island of central pairs needs no more than its first half.
template <class Real> struct alignas(2 * sizeof(Real)) HalfRecordOf {
	Real x, y;
};
template <class Real> struct alignas(4 * sizeof(Real)) BodyRecordOf {
	Real x, y, spin, inverseMass;
};
using HalfRecord = HalfRecordOf<double>;
using BodyRecord = BodyRecordOf<double>;

/// Which records the pairs of a block join, as offsets in numbers. A prescribed body has a record of its own in every slot.
struct alignas(64) PairBlock {
	std::uint32_t body1[blockWidth], body2[blockWidth];
};

/// A record is known by the number of its first half.
inline std::uint32_t offsetOf(std::int32_t record) { return 2 * std::uint32_t(record); }
inline std::int32_t  recordOf(std::uint32_t offset) { return std::int32_t(offset / 2); }
template <class Record, class Real> Record& recordAt(HalfRecordOf<Real>* first, std::uint32_t offset)
{
	return *reinterpret_cast<Record*>(reinterpret_cast<Real*>(first) + offset);
}

// One contact point of each pair of a block, by model; all are made of columns.

template <class Real> struct alignas(64) ColumnOf {
	Real of[blockWidth];
};
using Column = ColumnOf<double>;

/// The fields of all models.
template <class Real> struct alignas(64) PointBlockOf {
	Real oldPn[blockWidth]; // impulse one sweep before, for momentum
	Real nx[blockWidth], ny[blockWidth];
	Real bias[blockWidth], inverseNn[blockWidth];
	Real pn[blockWidth];   // impulse
	Real slip[blockWidth]; // tangential velocity that the records do not hold: of spins that stay as they are
};

template <class Real> struct CentralBlockOf : PointBlockOf<Real> {
	Real mass1[blockWidth], mass2[blockWidth]; // inverse
};

template <class Real> struct FrictionlessBlockOf : PointBlockOf<Real> {
	Real turn1n[blockWidth], turn2n[blockWidth], turn1t[blockWidth], turn2t[blockWidth]; // r/k as (x, y) until `prepare`
};

/// The fields of all that is rough.
template <class Real> struct RoundBlockOf : PointBlockOf<Real> {
	Real turn1t[blockWidth], turn2t[blockWidth];
	Real inverseSchur[blockWidth];
	Real pt[blockWidth];
	Real oldPt[blockWidth];
	Real friction[blockWidth]; // µ
};

template <class Real> struct FrictionalBlockOf : RoundBlockOf<Real> {
	Real turn1n[blockWidth], turn2n[blockWidth]; // with turn…t, r/k as (x, y) until `prepare`
	Real ratio[blockWidth];
	Real slidePlus[blockWidth], slideMinus[blockWidth];
};

using PointBlock        = PointBlockOf<double>;
using CentralBlock      = CentralBlockOf<double>;
using FrictionlessBlock = FrictionlessBlockOf<double>;
using RoundBlock        = RoundBlockOf<double>;
using FrictionalBlock   = FrictionalBlockOf<double>;

/// Columns of a block of that model.
constexpr int columnsOf(Model model)
{
	return int((model == Model::central              ? sizeof(CentralBlock)
	                    : model == Model::frictionless ? sizeof(FrictionlessBlock)
	                    : model == Model::round        ? sizeof(RoundBlock)
	                                                   : sizeof(FrictionalBlock))
	           / sizeof(Column));
}
static_assert(sizeof(FrictionalBlock) / sizeof(Column) == sizeof(FrictionalBlockOf<float>) / sizeof(ColumnOf<float>));

/// The blocks of one colour, with one model and one number of points a pair.
struct Chunk {
	std::int32_t firstPair, blocks, firstColumn, pointsPerPair;
	Model        model;
	std::int32_t firstPoint; // its blocks of points among those of all chunks
};

/// Everything the kernels touch.
template <class Real> struct PackedViewOf {
	HalfRecordOf<Real>* body;
	HalfRecordOf<Real>* oldBody; // one sweep before, for momentum
	PairBlock*          pairs;
	ColumnOf<Real>*     points;

	HalfRecordOf<Real>& halfBody(std::int32_t record) const { return body[record]; }
	BodyRecordOf<Real>& wholeBody(std::int32_t record) const { return recordAt<BodyRecordOf<Real>>(body, offsetOf(record)); }
};
using PackedView = PackedViewOf<double>;

/// Sums over points from which all stop criteria are made.
struct Measures {
	double error2     = 0; // ‖p − P_K(…)‖², the numerator of the residual
	double impulse2   = 0; // ‖p‖²
	double normal     = 0; // Σ p_n
	double violation2 = 0; // Σ w_nn² |p − P_K(…)|²
	double velocity2  = 0; // Σ |u|²
	double stopping2  = 0; // Σ ((|u_n| + |b_n|)/w_nn)²
	double taken      = 0; // −Σ p · (u + b_n n), energy

	Measures& operator+=(const Measures& other)
	{
		error2 += other.error2, impulse2 += other.impulse2, normal += other.normal;
		violation2 += other.violation2, velocity2 += other.velocity2, stopping2 += other.stopping2, taken += other.taken;
		return *this;
	}
};

/// The kernels for one lane width; each works on one chunk.
template <class Real> struct PackedKernelsOf {
	using View = PackedViewOf<Real>;

	int width;
	/// Lever arms and Delassus coefficients from the raw arms; returns Σ |u|² over the points.
	double (*prepare)(const View&, const Chunk&);
	/// Adds M⁻¹Jᵀp to the velocities.
	void (*apply)(const View&, const Chunk&);
	/// Solves every point once; the velocities follow.
	void (*sweep)(const View&, const Chunk&);
	/// An over-relaxed sweep: each impulse changes by `relaxation` times as much.
	void (*sweepRelaxed)(const View&, const Chunk&, double relaxation);
	/// A sweep from y = p + β (p − p_old); returns ‖p − y‖².
	double (*sweepMomentum)(const View&, const Chunk&, double momentum);
	/// The same with contacts that yield: the share `kept` of every solution.
	double (*sweepYielding)(const View&, const Chunk&, double momentum, double kept);
	/// Sums for the stop criteria at the present impulses and velocities; of floats about a reference, whose `bias` holds its velocities too, with
	/// those of the law, a column for each block of points.
	Measures (*measure)(const View&, const Chunk&, const ColumnOf<Real>* bias);
	/// Writes the velocities (u_n + b_n, u_t) of the points to `bias` and `slip` of blocks of floats: those of a reference.
	void (*refer)(const View&, const Chunk&, ColumnOf<float>* points);
	/// v_old ← v + β (v − v_old) for halves of records first … last − 1: the two then change places.
	void (*extrapolate)(const View&, int first, int last, double momentum);
};

using PackedKernels = PackedKernelsOf<double>;

/// The kernels for at most that many lanes (0: as many as is best) that this processor runs.
const PackedKernels&          packedKernels(int lanes);
const PackedKernelsOf<float>& singleKernels(int lanes);

} // namespace rcr

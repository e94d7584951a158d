// Memory layout of the packed contact problem, and the kernels that work on it.
//
// Pairs of bodies stand in blocks of sixteen that share no free body, so as many lanes may solve them at once: two AVX-512
// registers, since a point is a long chain of operations and one register alone would wait for it. A pair has one or two
// contact points; both are solved while its bodies are in registers. A slot without a pair holds zeros, which leave
// everything as it is.
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

constexpr int    blockWidth = 16;
constexpr double unlimited  = 1e300; // finite: 0 · unlimited is 0

struct alignas(32) BodyRecord {
	double x, y, spin, inverseMass;
};

/// Which records the pairs of a block join, as offsets in bytes. A prescribed body has a record of its own in every slot.
struct alignas(64) PairBlock {
	std::uint32_t body1[blockWidth], body2[blockWidth];
};

inline std::uint32_t offsetOf(std::int32_t record) { return record * std::uint32_t(sizeof(BodyRecord)); }
inline BodyRecord&   recordAt(BodyRecord* first, std::uint32_t offset)
{
	return *reinterpret_cast<BodyRecord*>(reinterpret_cast<char*>(first) + offset);
}

/// One contact point of each pair of a block.
struct alignas(64) PointBlock {
	double nx[blockWidth], ny[blockWidth];
	double turn1n[blockWidth], turn1t[blockWidth], turn2n[blockWidth], turn2t[blockWidth]; // r/k as (x, y) until `prepare`
	double bias[blockWidth], inverseNn[blockWidth], ratio[blockWidth], inverseSchur[blockWidth];
	double slidePlus[blockWidth], slideMinus[blockWidth];
	double pn[blockWidth], pt[blockWidth];       // impulse
	double oldPn[blockWidth], oldPt[blockWidth]; // impulse one sweep before, for momentum
	double friction[blockWidth];                 // µ: the plain sweep reads neither this nor the old impulse
};

/// A run of blocks of one colour, all with one or all with two points a pair: what a thread takes at a time.
struct Chunk {
	std::int32_t firstPair, blocks, firstPoint, pointsPerPair;
};

/// Everything the kernels touch.
struct PackedView {
	BodyRecord* body;
	BodyRecord* oldBody; // one sweep before, for momentum
	PairBlock*  pairs;
	PointBlock* points;
};

/// Sums over points from which all stop criteria are made.
struct Measures {
	double error2;     // ‖p − P_K(…)‖², the numerator of the residual
	double impulse2;   // ‖p‖²
	double normal;     // Σ p_n
	double violation2; // Σ w_nn² |p − P_K(…)|²
	double velocity2;  // Σ |u|²
	double stopping2;  // Σ ((|u_n| + |b_n|)/w_nn)²
};

/// The kernels for one lane width; each works on one chunk.
struct PackedKernels {
	int width;
	/// Lever arms and Delassus coefficients from the raw arms; returns Σ |u|² over the points.
	double (*prepare)(const PackedView&, const Chunk&);
	/// Adds M⁻¹Jᵀp to the velocities.
	void (*apply)(const PackedView&, const Chunk&);
	/// Solves every point once; the velocities follow.
	void (*sweep)(const PackedView&, const Chunk&);
	/// The same, each impulse changed by `relaxation` times as much.
	void (*sweepRelaxed)(const PackedView&, const Chunk&, double relaxation);
	/// The same from y = p + β (p − p_old); returns ‖p − y‖².
	double (*sweepMomentum)(const PackedView&, const Chunk&, double momentum);
	/// Sums for the stop criteria at the present impulses and velocities.
	Measures (*measure)(const PackedView&, const Chunk&);
	/// v_old ← v + β (v − v_old) for records first … last − 1: the two then change places.
	void (*extrapolate)(const PackedView&, int first, int last, double momentum);
};

/// The kernels for at most that many lanes (0: as many as is best) that this processor runs.
const PackedKernels& packedKernels(int lanes);

} // namespace rcr

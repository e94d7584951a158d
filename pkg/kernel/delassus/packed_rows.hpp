// Memory layout of packed rows of W, and the kernels that work on them.
//
// Rows of one colour have no block of W between them. Eight stand side by side as a slice, of like length; the blocks of their k-th
// neighbours follow each other, each number eight times. A short row ends in blocks of zeros, a lane without a row holds zeros, and both
// leave everything as it is. A row that finds none to stand beside it, as those of a wall that all touch each other, is a slice alone:
// its blocks stand one after the other, and Lane<1> solves it.
//
// | symbol | field        | unit | meaning                                                                       |
// |--------|--------------|------|-------------------------------------------------------------------------------|
// | q      | qn, qt       | m/s  | velocity of the point without impulses                                        |
// | w      | nn, nt, …    | 1/kg | diagonal block; those of neighbours are in RowView::numbers                    |
// | 1/w_nn | inverseNn    | kg   | 0 where nothing moves                                                         |
// | r      | ratio        | –    | w_nt / w_nn                                                                   |
// | 1/s    | inverseSchur | kg   | s = w_tt − w_tn w_nt/w_nn; `unlimited` where s ≤ 0: any slip slides            |
// | d±     | slide…       | –    | µ/(1 ± µ r), the largest ±p_t/n₀; where 1 ± µ r ≤ 0 `unlimited`, and 0 with s ≤ 0 |
// | u      | un, ut       | m/s  | velocity of the point, written by `measure`                                    |
#pragma once

#include <cstdint>

#include "sweep/packed_blocks.hpp"

namespace rcr {

constexpr int sliceWidth = 8;

/// Eight rows without their neighbours.
struct alignas(64) RowBlock {
	double qn[sliceWidth], qt[sliceWidth];
	double inverseNn[sliceWidth], ratio[sliceWidth], inverseSchur[sliceWidth];
	double slidePlus[sliceWidth], slideMinus[sliceWidth];
	double nn[sliceWidth], nt[sliceWidth], tn[sliceWidth], tt[sliceWidth];
	double friction[sliceWidth];
	double un[sliceWidth], ut[sliceWidth];
};

/// The places of a slice's blocks.
struct RowSlice {
	std::int32_t firstNeighbour; // in RowView::neighbours
	std::int32_t firstNumber;    // in RowView::numbers
	std::int32_t length;         // neighbours of its longest row
	std::int32_t rows;

	int width() const { return rows == 1 ? 1 : sliceWidth; }
};

/// Everything the kernels touch. The impulse (p_n, p_t) of lane i of slice k is in record sliceWidth · k + i.
struct RowView {
	const RowSlice*      slices;
	int                  count;
	RowBlock*            blocks;     // a slice
	const double*        numbers;    // nn, nt, tn, tt of every neighbour, each as often as the slice is wide
	const std::uint32_t* neighbours; // their records, as offsets in bytes
	HalfRecord*          impulse;
	HalfRecord*          old; // one sweep before, for momentum
};

/// The change that a sweep made.
struct RowChange {
	double change2  = 0; // ‖p − p_before‖²
	double impulse2 = 0; // ‖p‖²
};

/// Sums from which the residual is made.
struct RowSums {
	double error2    = 0; // ‖p − P_K(…)‖²
	double impulse2  = 0; // ‖p‖²
	double stopping2 = 0; // Σ (u_n/w_nn)²

	RowSums& operator+=(const RowSums& other)
	{
		error2 += other.error2, impulse2 += other.impulse2, stopping2 += other.stopping2;
		return *this;
	}
};

/// The kernels for one lane width.
struct RowKernels {
	/// Coefficients from the diagonal blocks and friction.
	void (*prepare)(const RowView&);
	/// Solves every row once.
	RowChange (*sweep)(const RowView&);
	/// An over-relaxed sweep: each impulse changes by `relaxation` times as much.
	RowChange (*sweepRelaxed)(const RowView&, double relaxation);
	/// p_old ← p + β (p − p_old): the two then change places.
	void (*extrapolate)(const RowView&, double momentum);
	/// Velocities for the present impulses, and their sums.
	RowSums (*measure)(const RowView&);
};

/// The kernels for at most that many lanes (0: as many as is best) that this processor runs.
const RowKernels& rowKernels(int lanes);

} // namespace rcr

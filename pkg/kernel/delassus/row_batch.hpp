// Rows of W and q as the sweeps need them: in batches that no block joins, coloured and packed.
//
// Islands are the connected parts of the graph of W. An island at rest, without impulses and with no point that approaches, is solved
// as it stands. A large island is a batch of its own; small islands of like size share one, which fills the lanes, and end together.
// The order of work, and with it every bit, depends on the problem alone, not on the width of the lanes.
#pragma once

#include <cstdint>
#include <vector>

#include "delassus/delassus_problem.hpp"
#include "delassus/packed_rows.hpp"

namespace rcr {

using RowIds = std::vector<std::int32_t>;

/// The batches of a problem: which rows are swept together. They take as long as two to five sweeps.
class Batches {
public:
	explicit Batches(const DelassusProblem&);

	int                 count() const { return int(begin_.size()) - 1; }
	const std::int32_t* begin(int batch) const { return rows_.data() + begin_[batch]; }
	const std::int32_t* end(int batch) const { return rows_.data() + begin_[batch + 1]; }

	/// Colour of a row, 0 … colors − 1, which none of its neighbours has; `colors` for the overflow.
	static constexpr int colors = 64; // rows that no colour takes are overflow
	int                  color(std::int32_t row) const { return color_[row]; }
	/// Number of the diagonal block of a row.
	std::int32_t diagonal(std::int32_t row) const { return diagonal_[row]; }

private:
	RowIds walk(const DelassusProblem&);

	RowIds rows_, begin_; // batch after batch; where each begins
	RowIds color_, diagonal_;
};

/// One batch; memory is kept from one to the next.
class RowBatch {
public:
	RowBatch(DelassusProblem& problem, const Batches& batches, int lanes)
	        : problem_(problem)
	        , batches_(batches)
	        , kernels_(rowKernels(lanes))
	        , slot_(problem.free.size())
	{
	}

	/// Loads these rows, with their impulses.
	void load(const std::int32_t* begin, const std::int32_t* end);
	/// Loads the impulses of the problem anew.
	void loadImpulses();
	/// Stores impulses, and velocities of the last `measure`, in the problem.
	void store();

	const RowIds& rows() const { return rows_; }
	/// Whether all impulses were zero when they were loaded.
	bool cold() const { return cold_; }

	/// A sweep solves every row once.
	RowChange sweep() { return kernels_.sweep(view()); }
	/// An over-relaxed sweep changes each impulse by `relaxation` times as much.
	RowChange sweepRelaxed(double relaxation) { return kernels_.sweepRelaxed(view(), relaxation); }
	/// p ← p + β (p − p_old), p_old ← p
	void extrapolate(double momentum)
	{
		kernels_.extrapolate(view(), momentum);
		impulse_.swap(old_);
	}
	/// Computes the velocities for the present impulses, and the sums of the residual.
	RowSums measure() { return kernels_.measure(view()); }

private:
	struct alignas(64) Records {
		HalfRecord of[sliceWidth];
	};
	struct alignas(64) Column {
		double of[sliceWidth];
	};

	void     sortRows();
	void     makeSlices();
	void     fill(const RowSlice&, const std::int32_t* rows, RowBlock&);
	int      neighbours(std::int32_t row) const { return problem_.rowStart[row + 1] - problem_.rowStart[row] - 1; }
	RowView  view()
	{
		return { slices_.data(), int(slices_.size()), blocks_.data(), numbers_.data()->of, neighbour_.data(), impulse_.data()->of, old_.data()->of };
	}

	DelassusProblem&           problem_;
	const Batches&             batches_;
	const RowKernels&          kernels_;
	RowIds                     rows_; // slice after slice
	RowIds                     slot_; // a row of the problem: sliceWidth · slice + lane
	std::vector<RowSlice>      slices_;
	std::vector<RowBlock>      blocks_; // a slice
	std::vector<Column>        numbers_;
	std::vector<std::uint32_t> neighbour_;
	std::vector<Records>       impulse_, old_; // a slice
	bool                       cold_ = true;
};

} // namespace rcr

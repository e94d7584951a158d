// Sparse LU of a matrix of 3×3 blocks, one block row a body of the plane.
//
//   A = L D U,   L and U unit triangular, D block diagonal;  A_ij ≠ 0 only where bodies i and j share a contact
//
// The pattern is symmetric, the values need not be. Rows are ordered once by approximate minimum degree (AMD of SuiteSparse)
// and not pivoted across blocks: A = I + Ĵᵀ K Ĵ of the contact problem is far from singular blocks, save by coincidence, which is reported.
// Source: Amestoy, Davis and Duff 1996 (order); Duff, Erisman and Reid 2017, ch. 5 and 12; Davis 2006, ch. 4 and 6 (left-looking factorisation).
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace rcr {

/// A 3×3 block, entry[column][row]; columns padded to four doubles, the padding is zero.
struct alignas(32) Block {
	double entry[3][4] = {};
};

/// One body's share of a vector, padded alike.
struct alignas(32) BlockVector {
	double entry[4] = {};
};

class BlockLu {
public:
	using Pair = std::pair<std::int32_t, std::int32_t>;

	BlockLu() = default;

	/// Orders `size` block rows and finds the pattern of the factors. Each pair names two different rows whose blocks
	/// may differ from zero; no pair twice.
	BlockLu(std::int32_t size, const std::vector<Pair>& pairs);

	void setIdentity();

	Block& diagonal(std::int32_t row) { return diagonal_[place_[row]]; }

	/// A_ij of pairs[k] = (i, j); transposed: A_ji.
	Block& pairBlock(std::int32_t pair, bool transposed)
	{
		const Slot slot = slots_[pair];
		return transposed == slot.below ? upper_[slot.entry] : lower_[slot.entry];
	}

	/// Overwrites A by its factors. False when a diagonal block turns out singular.
	bool factor();

	/// Overwrites b by A⁻¹ b. Needs `factor`.
	void solve(std::vector<BlockVector>& b) const;

	/// Blocks of L below the diagonal, fill included.
	std::size_t fill() const { return rows_.size(); }

private:
	struct Slot {
		std::int32_t entry;
		bool         below; // A_ij lies below the diagonal
	};

	void findPattern(const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbours);
	void transposePattern();
	void eliminate(std::int32_t step);

	std::int32_t              size_ = 0;
	std::vector<std::int32_t> order_, place_;        // elimination step -> row, row -> elimination step
	std::vector<std::int32_t> start_, rows_;         // column k of L, row k of U: rows_[start_[k]] …, ascending
	std::vector<std::int32_t> leftStart_, leftEntry_; // row k of L: its entries in lower_, by ascending column
	std::vector<std::int32_t> leftEnd_;               // … and where the column of each ends
	std::vector<std::int32_t> entryOfRow_;            // scratch of the factorisation: row -> entry of the present column
	std::vector<Slot>         slots_;                 // a pair -> its two blocks
	std::vector<Block>        diagonal_;              // D, inverted by `factor`
	std::vector<Block>        lower_, upper_;         // entries of L D and D U, then of L and D U
	mutable std::vector<BlockVector> work_;
};

} // namespace rcr

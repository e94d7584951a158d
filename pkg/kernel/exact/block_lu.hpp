// Sparse LU factorisation of a matrix of 3×3 blocks, one block row per body in the plane.
//
//   A = L D U,   L and U unit triangular, D block diagonal
//
// A_ij ≠ 0 only if bodies i and j share a contact. The pattern is symmetric; the values need not
// be. Rows are ordered once by approximate minimum degree (AMD of SuiteSparse). There is no
// pivoting across blocks: blocks of A = I + Ĵᵀ K Ĵ are singular only by coincidence, which `factor`
// reports. Source: Amestoy, Davis and Duff 1996 (order); Duff, Erisman and Reid 2017, ch. 5 and 12;
// Davis 2006, ch. 4 and 6 (left-looking factorisation).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace rcr {

/// A 3×3 block, entry[column][row]. Columns have four numbers; the fourth is zero.
struct alignas(32) Block {
	double entry[3][4] = {};
};

/// The part of a vector that belongs to one body. The fourth number is zero.
struct alignas(32) BlockVector {
	double entry[4] = {};
};

class BlockLu {
public:
	using Pair = std::pair<std::int32_t, std::int32_t>;

	BlockLu() = default;

	/// Orders `size` block rows and finds the pattern of the factors. Each pair (i, j) names two
	/// rows, i ≠ j, with nonzero A_ij and A_ji. No pair may occur twice.
	BlockLu(std::int32_t size, const std::vector<Pair>& pairs);

	void setIdentity();

	Block& diagonal(std::int32_t row) { return diagonal_[place_[row]]; }

	/// A_ij of pairs[pair] = (i, j), or A_ji if `transposed`.
	Block& pairBlock(std::int32_t pair, bool transposed)
	{
		const Slot slot = slots_[pair];
		return transposed == slot.below ? upper_[slot.entry] : lower_[slot.entry];
	}

	/// Overwrites A by its factors. Returns false if a diagonal block is singular.
	bool factor();

	/// b ← A⁻¹ b. Call `factor` before.
	void solve(std::vector<BlockVector>& b) const;

private:
	/// Entry of L, and the end of its column.
	struct Left {
		std::int32_t entry, end;
	};

	struct Slot {
		std::int32_t entry;
		bool         below; // A_ij lies below the diagonal
	};

	void findPattern(
	        const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbors);
	void eliminate(std::int32_t step);

	std::int32_t              size_ = 0;
	std::vector<std::int32_t> order_, place_; // elimination step → row; row → elimination step
	std::vector<std::int32_t> start_, rows_;  // column k of L and row k of U: rows_[start_[k]] …
	std::vector<std::int32_t> leftStart_;     // row k of L: left_[leftStart_[k]] …, by column
	std::vector<Left>         left_;
	std::vector<std::int32_t> entryOfRow_; // scratch of `factor`: row → entry of the present column
	std::vector<Slot>         slots_;      // blocks of each pair
	std::vector<Block>        diagonal_;   // D; after `factor` its inverse
	std::vector<Block>        lower_, upper_; // L D and D U; after `factor` L and D U
	mutable std::vector<BlockVector> work_;
};

} // namespace rcr

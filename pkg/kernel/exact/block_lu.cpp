#include "exact/block_lu.hpp"

#include <amd.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "problem/list_by_key.hpp"

// Clones for wider registers, chosen at load time. Products and sums stay separate
// (-ffp-contract=off), so all clones give the same bits. ThreadSanitizer does not support clones.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define RCR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define RCR_CLONES
#endif
#define RCR_INLINE inline __attribute__((always_inline))

namespace rcr {

namespace {

	/// A column of a block in one register. may_alias lets it access doubles.
	typedef double Column __attribute__((vector_size(32), may_alias));

	RCR_INLINE Column&       column(double* entry) { return *reinterpret_cast<Column*>(entry); }
	RCR_INLINE const Column& column(const double* entry)
	{
		return *reinterpret_cast<const Column*>(entry);
	}

	/// result = A x, one column
	RCR_INLINE void multiply(Column& result, const Block& a, const double* x)
	{
		result = column(a.entry[0]) * x[0] + column(a.entry[1]) * x[1] + column(a.entry[2]) * x[2];
	}

	/// C −= A B
	RCR_INLINE void subtractProduct(Block& c, const Block& a, const Block& b)
	{
		for (int j = 0; j < 3; ++j) {
			Column product;
			multiply(product, a, b.entry[j]);
			column(c.entry[j]) -= product;
		}
	}

	/// y −= A x
	RCR_INLINE void subtractProduct(BlockVector& y, const Block& a, const BlockVector& x)
	{
		Column product;
		multiply(product, a, x.entry);
		column(y.entry) -= product;
	}

	/// Inverts a block by Gauss–Jordan elimination with row exchanges. Returns false if it is
	/// singular.
	bool invert(Block& block)
	{
		double a[3][6];
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				a[i][j]     = block.entry[j][i];
				a[i][3 + j] = i == j;
			}
		for (int k = 0; k < 3; ++k) {
			int largest = k;
			for (int i = k + 1; i < 3; ++i)
				if (std::abs(a[i][k]) > std::abs(a[largest][k])) largest = i;
			if (!(std::abs(a[largest][k]) > 0)) return false; // zero or NaN
			std::swap(a[largest], a[k]);
			const double scale = 1 / a[k][k];
			for (double& value : a[k])
				value *= scale;
			for (int i = 0; i < 3; ++i) {
				if (i == k) continue;
				const double factor = a[i][k];
				for (int j = 0; j < 6; ++j)
					a[i][j] -= factor * a[k][j];
			}
		}
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				block.entry[j][i] = a[i][3 + j];
		return true;
	}

	/// Elimination order of a graph. Node i has the neighbours neighbors[begin[i]] …
	/// neighbors[begin[i + 1] − 1].
	std::vector<std::int32_t> minimumDegreeOrder(std::int32_t size,
	        const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbors)
	{
		const std::vector<std::int32_t> none(1); // AMD needs an array even without edges
		std::vector<std::int32_t>       order(size);
		const std::int32_t* const       list = (neighbors.empty() ? none : neighbors).data();
		if (size > 0
		        && amd_order(size, begin.data(), list, order.data(), nullptr, nullptr) < AMD_OK)
			throw std::bad_alloc();
		return order;
	}

	bool isZero(const BlockVector& x)
	{
		return x.entry[0] == 0 && x.entry[1] == 0 && x.entry[2] == 0;
	}

} // namespace

BlockLu::BlockLu(std::int32_t size, const std::vector<Pair>& pairs) : size_(size)
{
	std::vector<std::int32_t> begin, neighbors;
	listByKey(size, begin, neighbors, [&](auto add) {
		for (const Pair& pair : pairs)
			add(pair.first, pair.second), add(pair.second, pair.first);
	});
	findPattern(begin, neighbors);
	listByKey(size, leftStart_, left_, [&](auto add) {
		for (std::int32_t k = 0; k < size; ++k)
			for (std::int32_t m = start_[k]; m < start_[k + 1]; ++m)
				add(rows_[m], Left { m, start_[k + 1] });
	});
	for (const Pair& pair : pairs) {
		const std::int32_t i = place_[pair.first], j = place_[pair.second], k = std::min(i, j);
		const auto         entry = std::lower_bound(
		                rows_.begin() + start_[k], rows_.begin() + start_[k + 1], std::max(i, j));
		slots_.push_back({ static_cast<std::int32_t>(entry - rows_.begin()), i > j });
	}
	diagonal_.resize(size);
	lower_.resize(rows_.size());
	upper_.resize(rows_.size());
	work_.resize(size);
	entryOfRow_.resize(size);
}

/// Column k of L has the later neighbours of row k and the columns of its children in the
/// elimination tree.
void BlockLu::findPattern(
        const std::vector<std::int32_t>& begin, const std::vector<std::int32_t>& neighbors)
{
	order_ = minimumDegreeOrder(size_, begin, neighbors);
	place_.resize(size_);
	for (std::int32_t k = 0; k < size_; ++k)
		place_[order_[k]] = k;
	std::vector<std::int32_t> mark(size_, -1), firstChild(size_, -1), sibling(size_, -1), column;
	start_.assign(1, 0);
	for (std::int32_t k = 0; k < size_; ++k) {
		const auto add = [&](std::int32_t i) {
			if (i <= k || mark[i] == k) return;
			mark[i] = k;
			column.push_back(i);
		};
		column.clear();
		for (std::int32_t m = begin[order_[k]]; m < begin[order_[k] + 1]; ++m)
			add(place_[neighbors[m]]);
		for (std::int32_t child = firstChild[k]; child >= 0; child = sibling[child])
			for (std::int32_t m = start_[child]; m < start_[child + 1]; ++m)
				add(rows_[m]);
		std::sort(column.begin(), column.end());
		if (!column.empty()) {
			sibling[k]                 = firstChild[column.front()];
			firstChild[column.front()] = k;
		}
		rows_.insert(rows_.end(), column.begin(), column.end());
		start_.push_back(static_cast<std::int32_t>(rows_.size()));
	}
}

void BlockLu::setIdentity()
{
	Block one;
	for (int i = 0; i < 3; ++i)
		one.entry[i][i] = 1;
	std::fill(diagonal_.begin(), diagonal_.end(), one);
	std::fill(lower_.begin(), lower_.end(), Block {});
	std::fill(upper_.begin(), upper_.end(), Block {});
}

/// Subtracts the terms L_ik (D U)_kj of earlier columns k from column `step` of L D and from row
/// `step` of D U.
RCR_CLONES void BlockLu::eliminate(std::int32_t step)
{
	for (std::int32_t m = start_[step]; m < start_[step + 1]; ++m)
		entryOfRow_[rows_[m]] = m;
	for (std::int32_t place = leftStart_[step]; place < leftStart_[step + 1]; ++place) {
		const Left  left = left_[place];
		const Block l = lower_[left.entry], u = upper_[left.entry];
		subtractProduct(diagonal_[step], l, u);
		for (std::int32_t m = left.entry + 1; m < left.end; ++m) {
			const std::int32_t entry = entryOfRow_[rows_[m]];
			subtractProduct(lower_[entry], lower_[m], u);
			subtractProduct(upper_[entry], l, upper_[m]);
		}
	}
}

RCR_CLONES bool BlockLu::factor()
{
	for (std::int32_t k = 0; k < size_; ++k) {
		eliminate(k);
		if (!invert(diagonal_[k])) return false;
		for (std::int32_t m = start_[k]; m < start_[k + 1]; ++m) {
			const Block ld = lower_[m];
			for (int j = 0; j < 3; ++j)
				multiply(column(lower_[m].entry[j]), ld, diagonal_[k].entry[j]);
		}
	}
	return true;
}

RCR_CLONES void BlockLu::solve(std::vector<BlockVector>& b) const
{
	BlockVector* x = work_.data();
	for (std::int32_t k = 0; k < size_; ++k)
		x[k] = b[order_[k]];
	for (std::int32_t k = 0; k < size_; ++k) {
		if (isZero(x[k])) continue; // a single contact reaches few bodies in this loop
		for (std::int32_t m = start_[k]; m < start_[k + 1]; ++m)
			subtractProduct(x[rows_[m]], lower_[m], x[k]);
	}
	for (std::int32_t k = size_ - 1; k >= 0; --k) {
		for (std::int32_t m = start_[k]; m < start_[k + 1]; ++m)
			subtractProduct(x[k], upper_[m], x[rows_[m]]);
		Column result;
		multiply(result, diagonal_[k], x[k].entry);
		column(b[order_[k]].entry) = result;
		column(x[k].entry)         = result;
	}
}

} // namespace rcr

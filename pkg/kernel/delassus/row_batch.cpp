#include "delassus/row_batch.hpp"

#include <algorithm>

namespace rcr {

namespace {

	constexpr int maxBatchRows = 256; // rows of small islands in a batch: more would end maxBatchRows, fewer leave lanes empty
	constexpr int maxLoneRows  = 2;   // rows of a colour left over that cost less one by one than as a slice

	/// Orders items by their key, 0 to `largest`; those of one key stay as they are.
	template <class Key> void sortByKey(RowIds& items, int largest, Key key)
	{
		RowIds start(largest + 2), sorted(items.size());
		for (const std::int32_t item : items)
			++start[key(item) + 1];
		for (int k = 1; k <= largest; ++k)
			start[k] += start[k - 1];
		for (const std::int32_t item : items)
			sorted[start[key(item)]++] = item;
		items.swap(sorted);
	}

} // namespace

Batches::Batches(const DelassusProblem& problem) : color_(problem.free.size()), diagonal_(problem.free.size())
{
	const RowIds       island = walk(problem); // known by its first row
	const std::int32_t count  = std::int32_t(island.size());
	RowIds             size(count), moves(count), islands, batch(count, -1);
	for (std::int32_t k = 0; k < count; ++k) {
		++size[island[k]];
		moves[island[k]] |= (problem.free[k].n < 0) | (problem.impulse[k].n != 0) | (problem.impulse[k].t != 0);
	}
	for (std::int32_t k = 0; k < count; ++k)
		if (moves[k]) islands.push_back(k);
	sortByKey(islands, maxBatchRows, [&](std::int32_t i) { return std::min(size[i], maxBatchRows); });
	std::int32_t total = 0;
	for (const std::int32_t i : islands) {
		if (begin_.empty() || total - begin_.back() + size[i] > maxBatchRows) begin_.push_back(total);
		batch[i] = std::int32_t(begin_.size()) - 1;
		total += size[i];
	}
	RowIds next = begin_;
	begin_.push_back(total);
	rows_.resize(total);
	for (std::int32_t k = 0; k < count; ++k)
		if (batch[island[k]] >= 0) rows_[next[batch[island[k]]]++] = k;
}

/// Colours the rows and finds their diagonals; returns the first row of the island of each.
RowIds Batches::walk(const DelassusProblem& problem)
{
	const std::int32_t         count  = std::int32_t(problem.free.size());
	const std::int32_t*        column = problem.column.data();
	std::vector<std::uint64_t> bit(count); // of the colour of a row
	RowIds                     parent(count); // an earlier row of the same island; a row without one is the first
	for (std::int32_t k = 0; k < count; ++k) {
		std::int32_t  e = problem.rowStart[k], first = k;
		std::uint64_t taken = 0;
		parent[k]           = k;
		for (; column[e] < k; ++e) {
			std::int32_t other = column[e];
			taken |= bit[other];
			if (parent[other] == first) continue;
			while (parent[other] != other)
				other = parent[other] = parent[parent[other]];
			parent[std::max(first, other)] = std::min(first, other);
			first                          = std::min(first, other);
		}
		diagonal_[k] = e;
		bit[k]       = ~taken & (taken + 1); // the lowest that is free
		color_[k]    = bit[k] ? __builtin_ctzll(bit[k]) : colors;
	}
	for (std::int32_t& first : parent)
		first = parent[first];
	return parent;
}

void RowBatch::load(const std::int32_t* begin, const std::int32_t* end)
{
	rows_.assign(begin, end);
	sortRows();
	makeSlices();
	const std::int32_t* rows = rows_.data();
	for (std::size_t k = 0; k < slices_.size(); rows += slices_[k++].rows)
		fill(slices_[k], rows, blocks_[k]);
	kernels_.prepare(view());
	loadImpulses();
}

/// Sorts the rows by colour, those of one colour by length, the longest first.
void RowBatch::sortRows()
{
	int longest = 0, last = 0;
	for (const std::int32_t row : rows_) {
		longest = std::max(longest, neighbours(row));
		last    = std::max(last, batches_.color(row));
	}
	const int lengths = longest + 1;
	sortByKey(rows_, (last + 1) * lengths, [&](std::int32_t row) { return batches_.color(row) * lengths + longest - neighbours(row); });
}

void RowBatch::makeSlices()
{
	std::int32_t entries = 0, numbers = 0;
	slices_.clear();
	for (auto row = rows_.begin(); row != rows_.end();) {
		const int  color = batches_.color(*row);
		const auto limit = row + std::min<std::ptrdiff_t>(rows_.end() - row, color == Batches::colors ? 1 : sliceWidth);
		const int  rows  = int(std::find_if(row, limit, [&](std::int32_t other) { return batches_.color(other) != color; }) - row);
		slices_.push_back({ entries, numbers, neighbours(*row), rows <= maxLoneRows ? 1 : rows });
		const RowSlice& slice = slices_.back();
		for (int lane = 0; lane < slice.rows; ++lane)
			slot_[*row++] = sliceWidth * (std::int32_t(slices_.size()) - 1) + lane;
		entries += slice.length * slice.width();
		numbers += (4 * slice.length * slice.width() + sliceWidth - 1) / sliceWidth * sliceWidth; // whole columns
	}
	blocks_.resize(slices_.size());
	impulse_.resize(slices_.size());
	old_.resize(slices_.size());
	numbers_.resize(numbers / sliceWidth + 1); // never empty: rows without neighbours point into them, too
	neighbour_.resize(entries + sliceWidth);
}

/// Rows of W, padded with zeros. All rows of a slice take the same way through the loop: branches foreseen are half of the time.
void RowBatch::fill(const RowSlice& slice, const std::int32_t* rows, RowBlock& block)
{
	static constexpr DelassusBlock zero {};
	const int                      width = slice.width();
	block                                = {};
	for (int lane = 0; lane < width; ++lane) {
		double*            number    = numbers_.data()->of + slice.firstNumber + lane;
		std::uint32_t*     neighbour = neighbour_.data() + slice.firstNeighbour + lane;
		const std::int32_t row       = rows[std::min(lane, slice.rows - 1)], first = problem_.rowStart[row], diagonal = batches_.diagonal(row);
		const int          count     = lane < slice.rows ? neighbours(row) : 0;
		for (int i = 0; i < slice.length; ++i, number += 4 * width, neighbour += width) {
			const std::int32_t   e = i < count ? first + i + (first + i >= diagonal) : diagonal;
			const DelassusBlock& w = i < count ? problem_.block[e] : zero;
			number[0] = w.nn, number[width] = w.nt, number[2 * width] = w.tn, number[3 * width] = w.tt;
			*neighbour = offsetOf(slot_[problem_.column[e]]);
		}
		if (lane >= slice.rows) continue;
		const DelassusBlock& w = problem_.block[diagonal];
		block.qn[lane] = problem_.free[row].n, block.qt[lane] = problem_.free[row].t, block.friction[lane] = problem_.friction[row];
		block.nn[lane] = w.nn, block.nt[lane] = w.nt, block.tn[lane] = w.tn, block.tt[lane] = w.tt;
	}
}

void RowBatch::loadImpulses()
{
	cold_ = true;
	impulse_.assign(slices_.size(), {});
	for (const std::int32_t row : rows_) {
		const Impulse      p     = problem_.impulse[row];
		const std::int32_t slice = slot_[row] / sliceWidth, lane = slot_[row] % sliceWidth;
		if (blocks_[slice].inverseNn[lane] > 0) impulse_[slice].of[lane] = { p.n, p.t }; // nothing between two prescribed bodies
		cold_ = cold_ && p.n == 0 && p.t == 0;
	}
	old_ = impulse_;
}

void RowBatch::store()
{
	for (const std::int32_t row : rows_) {
		const std::int32_t slice = slot_[row] / sliceWidth, lane = slot_[row] % sliceWidth;
		problem_.impulse[row]  = { impulse_[slice].of[lane].x, impulse_[slice].of[lane].y };
		problem_.velocity[row] = { blocks_[slice].un[lane], blocks_[slice].ut[lane] };
	}
}

} // namespace rcr

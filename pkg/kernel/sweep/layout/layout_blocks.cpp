// The blocks of a section: colours of its pairs, and their slots.
#include "sweep/layout/layout.hpp"

namespace rcr {

/// Colours the pairs of a section and counts them. Uses records as numbers of bodies: those of a
/// partition are consecutive, so threads write to different cache lines.
void Layout::color(Section& section)
{
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const PackedPair& pair = pairs_[bySection_[k]];
		for (int body : { pair.body1, pair.body2 })
			if (moves(body)) coloring_.free(record_[body]);
	}
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const int         number = bySection_[k];
		const PackedPair& pair   = pairs_[number];
		const bool        moves1 = moves(pair.body1), moves2 = moves(pair.body2);
		const int color = coloring_.take(record_[pair.body1], moves1, record_[pair.body2], moves2);
		color_[number]  = static_cast<signed char>(color);
		if (color == none) continue;
		++section.row(color, pair).pairs;
		section.prescribedRecords += !moves1 + !moves2;
	}
}

void Layout::makeBlocks(Section& section)
{
	section.chunks.begin = int(chunks_.size());
	for (auto& ofColor : section.rows)
		for (int m = 0; m < models; ++m)
			for (int points : { 2, 1 })
				if (ofColor[m][points - 1].pairs > 0)
					makeBlocks(ofColor[m][points - 1], Model(m), points);
	section.chunks.end = int(chunks_.size());
	section.nextRecord = appendRecords(section.prescribedRecords);
}

/// Makes the blocks of a row. Its last slots may stay empty.
void Layout::makeBlocks(Row& row, Model model, int points)
{
	const int first = int(pairBlocks_.size()), blocks = (row.pairs + blockWidth - 1) / blockWidth;
	row.firstBlock  = first;
	row.nextSlot    = first * blockWidth;
	row.firstColumn = columns_;
	chunks_.push_back({ first, blocks, columns_, points, model, pointBlocks_ });
	pointBlocks_ += blocks * points;
	pairBlocks_.resize(first + blocks);
	columns_ += blocks * points * columnsOf(model);
	if (row.pairs == blocks * blockWidth) return;
	for (int lane = row.pairs % blockWidth; lane < blockWidth; ++lane) {
		pairBlocks_.back().body1[lane] = offsetOf(appendRecords(1));
		pairBlocks_.back().body2[lane] = offsetOf(appendRecords(1));
	}
	vacant_.push_back({ columns_ - points * columnsOf(model), columns_ });
}

/// Gives each pair of a section the next slot of its row, and each prescribed body in it
/// a separate record.
void Layout::place(Section& section)
{
	const auto side = [&](int body) {
		if (moves(body)) return offsetOf(record_[body]);
		section.nextRecord += 2;
		return offsetOf(section.nextRecord - 2);
	};
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const int number = bySection_[k];
		if (color_[number] == none) continue;
		PackedPair& pair = pairs_[number];
		Row&        row  = section.row(color_[number], pair);
		pair.slot        = row.nextSlot++;
		const int block = pair.slot / blockWidth, lane = pair.slot % blockWidth;
		pair.column = row.firstColumn
		        + (block - row.firstBlock) * pair.points * columnsOf(pair.model);
		pairBlocks_[block].body1[lane] = side(pair.body1);
		pairBlocks_[block].body2[lane] = side(pair.body2);
	}
}

/// Appends whole records and returns the first.
int Layout::appendRecords(int count)
{
	const int first = (records_ + 1) / 2 * 2;
	if (count > 0) records_ = first + 2 * count;
	return first;
}

} // namespace rcr

// The blocks of a section: its pairs coloured, and each given a slot.
#include "sweep/layout.hpp"

namespace rcr {

/// Lays a section out in blocks of its own.
void Layout::layOut(Section& section)
{
	section.chunks.begin = int(chunks_.size());
	color(section);
	for (auto& ofColor : rows_)
		for (int m = 0; m < models; ++m)
			for (int points : { 2, 1 })
				makeBlocks(ofColor[m][points - 1], Model(m), points);
	section.chunks.end = int(chunks_.size());
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const int number = bySection_[k];
		if (color_[number] != Coloring::none) place(pairs_[number], row(color_[number], pairs_[number]));
	}
}

/// Colours the pairs of a section and counts them.
void Layout::color(const Section& section)
{
	for (auto& ofColor : rows_)
		for (auto& ofModel : ofColor)
			ofModel[0] = ofModel[1] = {};
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const LaidPair& pair = pairs_[bySection_[k]];
		coloring_.free(pair.body1);
		coloring_.free(pair.body2);
	}
	for (int k = section.pairs.begin; k < section.pairs.end; ++k) {
		const int   number = bySection_[k];
		const LaidPair& pair   = pairs_[number];
		const int   color  = coloring_.take(pair.body1, moves(pair.body1), pair.body2, moves(pair.body2));
		color_[number]     = static_cast<signed char>(color);
		if (color != Coloring::none) ++row(color, pair).pairs;
	}
}

/// Makes the blocks for the pairs counted; the slots that stay vacant are the last of each row.
void Layout::makeBlocks(Row& row, Model model, int points)
{
	const int first = int(pairBlocks_.size()), blocks = (row.pairs + blockWidth - 1) / blockWidth;
	row.firstBlock  = first;
	row.nextSlot    = first * blockWidth;
	row.firstColumn = columns_;
	if (blocks > 0) chunks_.push_back({ first, blocks, columns_, points, model });
	pairBlocks_.resize(first + blocks);
	columns_ += blocks * points * columnsOf(model);
	if (row.pairs == blocks * blockWidth) return;
	for (int lane = row.pairs % blockWidth; lane < blockWidth; ++lane) {
		pairBlocks_.back().body1[lane] = offsetOf(ownRecord(model));
		pairBlocks_.back().body2[lane] = offsetOf(ownRecord(model));
	}
	vacant_.push_back({ columns_ - points * columnsOf(model), columns_ });
}

/// Gives a pair the next slot of its row; a prescribed side gets a record of its own, which no impulse moves.
void Layout::place(LaidPair& pair, Row& row)
{
	const auto side = [&](int body) { return offsetOf(moves(body) ? record_[body] : ownRecord(pair.model)); };
	pair.slot       = row.nextSlot++;
	const int block = pair.slot / blockWidth, lane = pair.slot % blockWidth;
	pair.column     = row.firstColumn + (block - row.firstBlock) * pair.points * columnsOf(pair.model);
	pairBlocks_[block].body1[lane] = side(pair.body1);
	pairBlocks_[block].body2[lane] = side(pair.body2);
}

int Layout::ownRecord(Model model)
{
	if (model == Model::central) return records_++;
	records_ = (records_ + 1) / 2 * 2;
	return (records_ += 2) - 2;
}

} // namespace rcr

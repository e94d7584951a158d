// Where each pair of bodies stands in the packed arrays.
//
// A pure function of the present problem, its pairs in order and the kinds of its bodies, so that a simulation that is
// saved and loaded goes on to the same bits. Where these are as before it is kept, else made anew: as much work as one or
// two sweeps.
#pragma once

#include <vector>

#include "coloring.hpp"
#include "contact_problem.hpp"
#include "packed_blocks.hpp"

namespace rcr {

/// Regular: one inverse mass along x and y. Prescribed: none at all. Special: a wall free along one axis, a pivot.
enum class BodyKind : unsigned char { regular, prescribed, special };

/// One or two neighbouring points between the same two bodies.
struct Pair {
	static constexpr std::int32_t outside = -1;

	std::int32_t body1, body2, firstPoint, points;
	std::int32_t slot;       // blockWidth · block + lane; or `outside` the colours: special bodies, bodies with too many contacts
	std::int32_t pointBlock; // of its first point; the second is in the next
};

class Layout {
public:
	/// Lays the problem out; false if everything stands where it stood.
	bool update(const ContactProblem&);

	const std::vector<Pair>&         pairs() const { return pairs_; } // in the order of the problem
	std::vector<PairBlock>&          pairBlocks() { return pairBlocks_; }
	const std::vector<std::int32_t>& vacantBlocks() const { return vacantBlocks_; } // point blocks with vacant lanes
	int                              pointBlocks() const { return pointBlocks_; }
	BodyKind                         kind(int body) const { return kind_[body]; }
	/// Records of bodies, then of the prescribed sides of pairs and both sides of vacant slots.
	int records() const { return records_; }

	const std::vector<Chunk>& chunks() const { return chunks_; }
	/// Chunks of a colour: from chunkBegin(color) to chunkBegin(color + 1).
	int chunkBegin(int color) const { return chunkBegin_[color]; }

private:
	/// The blocks of one colour and number of points: the next slot to fill and where they begin.
	struct Row {
		std::int32_t pairs = 0, nextSlot, firstBlock, firstPoint;
	};

	bool sortBodies(const ContactProblem&);
	bool findPairs(const ContactProblem&);
	bool packable(const Pair&) const;
	void color();
	void makeBlocks();
	void place(Pair&, int color);
	int  ownRecord() { return records_++; }
	Row& row(int color, int points) { return rows_[color][points - 1]; }

	std::vector<BodyKind>     kind_;
	std::vector<Pair>         pairs_;
	std::vector<signed char>  color_; // a pair
	Row                       rows_[Coloring::colors][2];
	std::vector<PairBlock>    pairBlocks_;
	std::vector<Chunk>        chunks_; // by colour
	int                       chunkBegin_[Coloring::colors + 1] = {};
	int                       pointBlocks_ = 0, records_ = 0;
	std::vector<std::int32_t> vacantBlocks_;
	Coloring                  coloring_;
};

} // namespace rcr

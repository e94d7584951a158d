// Where each pair of bodies stands in the packed arrays, kept between steps.
//
// Pairs keep their slot while they last; a pair that comes takes a vacant slot of a colour that is free at both bodies.
// All is laid out anew when bodies change kind or too many slots stand empty.
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
	std::int32_t slot; // 8 · block + lane; or `outside` the colours: special bodies, bodies with too many contacts

	bool before(const Pair& other) const { return body1 != other.body1 ? body1 < other.body1 : body2 < other.body2; }
	bool sameAs(const Pair& other) const { return body1 == other.body1 && body2 == other.body2 && points == other.points; }
};

class Layout {
public:
	/// Follows the bodies and points of the problem; true if all slots were laid out anew.
	bool update(const ContactProblem&);

	const std::vector<Pair>&         pairs() const { return pairs_; } // in the order of the problem
	std::vector<PairBlock>&          pairBlocks() { return pairBlocks_; }
	const std::vector<std::int32_t>& vacated() const { return vacated_; } // slots that the last update left empty
	int                              pointBlocks() const { return pointBlocks_; }
	BodyKind                         kind(int body) const { return kind_[body]; }
	int                              firstPoint(int slot) const { return blocks_[slot / blockWidth].firstPoint; } // its point block
	int                              pointsPerPair(int slot) const { return blocks_[slot / blockWidth].points; }
	/// Records of bodies, then of the prescribed or missing side of each slot.
	int records() const { return int(kind_.size()) + 2 * blockWidth * int(pairBlocks_.size()); }

	const std::vector<Chunk>& chunks() const { return chunks_; }
	/// Chunks of a colour: from chunkBegin(color) to chunkBegin(color + 1).
	int chunkBegin(int color) const { return chunkBegin_[color]; }

private:
	struct Block {
		std::int32_t firstPoint, points, color;
	};
	using Slots = std::vector<std::int32_t>;

	bool   sortBodies(const ContactProblem&);
	bool   keep(std::vector<Pair>&);
	void   make(std::vector<Pair>&);
	bool   packable(const Pair&) const;
	void   place(Pair&);
	void   settle(Pair&, int color);
	void   vacate(const Pair&);
	void   addBlocks(int color, int points, int count);
	void   clear(int slot);
	Slots& vacant(int color, int points) { return vacant_[color][points - 1]; }

	std::vector<BodyKind>  kind_;
	std::vector<Pair>      pairs_;
	std::vector<Block>     blocks_;
	std::vector<PairBlock> pairBlocks_;
	std::vector<Chunk>     chunks_; // by colour
	int                    chunkBegin_[Coloring::colors + 1] = {};
	int                    pointBlocks_                      = 0;
	Slots                  vacant_[Coloring::colors][2], vacated_;
	Coloring               coloring_;
};

} // namespace rcr

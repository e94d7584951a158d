// The layout of a problem: the place of each pair of bodies in the packed arrays, its model, and the islands solved apart.
//
// The layout is a pure function of the present problem: its pairs in order, their needs and the kinds of its bodies. So a
// simulation that is saved and loaded goes on to the same bits. A layout is kept while these stay as they are; a new one is as
// much work as twenty sweeps in floats.
//
// Islands are the connected parts of the graph of bodies; prescribed bodies do not connect. A large island is cut into slabs
// (slabs.hpp). Its pairs stand in sections, those within a slab or those that join slabs, each with blocks of its own, coloured:
// one thread sweeps a section colour after colour, all slabs may be swept at once, and then all joints. The overflow is solved pair
// after pair: pairs that no colour takes, pairs of special bodies, and all pairs of an island so small that it would leave most
// slots vacant. The result of an island does not depend on what else is there.
#pragma once

#include <vector>

#include "sweep/layout/coloring.hpp"
#include "problem/contact_problem.hpp"
#include "sweep/lane/packed_blocks.hpp"
#include "problem/reductions.hpp"
#include "sweep/layout/partitions.hpp"

namespace rcr {

/// Regular: one inverse mass along x and y. Prescribed: none at all. Special: a wall free along one axis, a pivot.
enum class BodyKind : unsigned char { regular, prescribed, special };

/// One or two neighbouring points between the same two bodies.
struct LaidPair {
	static constexpr std::int32_t noSlot = -1; // of the overflow, and of pairs that belong to no island

	std::int32_t body1, body2, firstPoint, points;
	Model        needs;      // the least that serves it
	Model        model;      // the one it has
	bool         drifts;     // across a periodic boundary: no colour takes it
	std::int32_t slot;       // blockWidth · block + lane, or noSlot
	std::int32_t column;     // where the block of its first point begins; that of the second follows
};

struct Range {
	std::int32_t begin = 0, end = 0;
};

/// The blocks of one colour, model and number of points: the next slot to fill and where they begin.
struct Row {
	std::int32_t pairs = 0, nextSlot = 0, firstBlock = 0, firstColumn = 0;
};

/// Pairs that one thread sweeps, chunk after chunk: those within a slab, or those that join some slabs to the next ones.
struct Section {
	Range chunks;  // in Layout::chunks
	Range records; // halves, of the bodies of a slab
	Range pairs;   // in Layout::bySection
	Row   rows[Coloring::colors][models][2];
	std::int32_t sides = 0; // prescribed ones of its pairs that have slots, each with a record of its own …
	std::int32_t nextRecord = 0; // … of which this is the next

	Row& row(int color, const LaidPair& pair) { return rows[color][int(pair.model)][pair.points - 1]; }
};

/// A part of the problem that is solved apart.
struct Island {
	std::int32_t points = 0;
	bool         shared  = false; // large enough that several threads work on it
	bool         central = false; // nothing turns: half records
	bool         cell    = false; // the one of all pairs across the boundary of a cell that may stretch
	Range        pairs;          // in Layout::byIsland
	Range        loose;          // records, halves, of bodies that only overflow touches
	Range        slabs, joints;  // in Layout::sections: those of one range share no body
	Range        overflow;       // in Layout::overflow
};

class Layout {
public:
	/// Lays the problem out; false if everything stands where it stood.
	bool update(const ContactProblem&, const Reductions&, ThreadTeam&);

	const std::vector<LaidPair>&     pairs() const { return pairs_; } // in the order of the problem
	std::vector<PairBlock>&          pairBlocks() { return pairBlocks_; }
	const std::vector<Range>&        vacant() const { return vacant_; } // columns of point blocks with vacant lanes
	int                              columns() const { return columns_; }
	int                              pointBlocks() const { return pointBlocks_; }
	BodyKind                         kind(int body) const { return kind_[body]; }

	/// Halves of records of bodies, then of the prescribed sides of pairs and both sides of vacant slots.
	int records() const { return records_; }
	/// Record of a body. Order: bodies of island 0, of island 1, …, each slab after slab; bodies without an island last.
	int  record(int body) const { return record_[body]; }
	bool central(int body) const { return island_[body] != none && islands_[island_[body]].central; }

	const std::vector<Island>&       islands() const { return islands_; }
	const std::vector<std::int32_t>& overflow() const { return overflow_; } // pairs, by island
	const std::vector<Section>&      sections() const { return sections_; }
	const std::vector<Chunk>&        chunks() const { return chunks_; }

	ModelSummary summary() const;

private:
	/// Of a point what the layout depends on.
	struct Kind {
		std::int32_t body1, body2;
		Model        needs;
		bool         drifts;
	};

	bool  sortBodies(const ContactProblem&);
	bool  findPairs(const ContactProblem&, ThreadTeam&);
	Model need(const ContactProblem&, const ContactPoint&) const;
	bool  moves(int body) const { return kind_[body] != BodyKind::prescribed || !reductions_.fixed; }
	bool  packable(const LaidPair&) const;
	void  findIslands();
	int   islandOf(const LaidPair& pair) const { return island_[moves(pair.body1) ? pair.body1 : pair.body2]; }
	void  sortPairs();
	void  chooseModels(Island&);
	void  cut(Island&);
	int   sectionOf(const LaidPair&) const;
	void  sortSections();
	void  numberRecords();
	void  color(Section&);
	void  makeBlocks(Section&);
	void  makeBlocks(Row&, Model, int points);
	void  place(Section&);
	void  listOverflow(Island&);
	int   ownRecords(int count);

	static constexpr std::int32_t none = -1;

	Reductions                reductions_;
	bool                      stretches_ = false; // the cell may
	std::vector<BodyKind>     kind_;
	std::vector<Kind>         kinds_; // a point
	std::vector<LaidPair>     pairs_;
	std::vector<std::int32_t> island_, record_; // a body
	std::vector<Island>       islands_;
	Slabs                     slabs_;
	std::vector<Slabs::Edge>  edges_; // of an island
	std::vector<Section>      sections_; // slabs of all islands, then joints
	int                       slabSections_ = 0;
	std::vector<std::int32_t> byIsland_, bySection_, overflow_; // pairs
	std::vector<signed char>  color_;                           // a pair
	std::vector<PairBlock>    pairBlocks_;
	std::vector<Chunk>        chunks_; // by section
	int                       columns_ = 0, pointBlocks_ = 0, records_ = 0;
	std::vector<Range>        vacant_;
	Coloring                  coloring_;
};

} // namespace rcr

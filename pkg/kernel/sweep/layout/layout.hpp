// The layout of a problem: islands, the model of each pair and its place in the packed arrays.
//
// The layout depends on the present problem alone: on its pairs in order, their required models,
// the kinds of bodies, and whether the stretch rate of a cell lags. So a simulation that is saved
// and loaded continues with the same bits. A layout is kept until one of these changes; a new layout
// takes as long as twenty sweeps in floats.
//
// Islands are the connected parts of the graph of bodies; prescribed bodies do not connect. A
// large island is cut into partitions (partitions.hpp). Its pairs form sections: those within a
// partition, or those on some interfaces. A section has its own blocks and colours. One thread
// sweeps a section colour after colour; all partitions may be swept at once, and then all
// interfaces.
//
// The overflow is solved pair after pair. It contains pairs without a colour, pairs of special
// bodies, and pairs across the boundary of a moving cell. All pairs of a small island belong to it.
// A small island would leave most slots empty. A cell that may stretch is one island. Its pairs
// with prescribed bodies are overflow too, and all its pairs if its stretch rate must not lag.
#pragma once

#include "problem/contact_problem.hpp"
#include "problem/error_estimate.hpp"
#include "problem/reductions.hpp"
#include "sweep/lane/packed_blocks.hpp"
#include "sweep/layout/coloring.hpp"
#include "sweep/layout/partitions.hpp"

namespace rcr {

/// Regular: one inverse mass along x and y. Prescribed: all inverse masses zero.
/// Special: a wall free along one axis, or a hinged body.
enum class BodyKind : unsigned char { regular, prescribed, special };

/// One or two consecutive points between the same two bodies.
struct PackedPair {
	std::int32_t body1, body2, firstPoint, points;
	Model        required; // the cheapest model that holds
	Model        model;    // the model in use
	bool         crossesMovingCell; // its image moves or may move (CellStress): overflow
	bool         frictional;        // µ > 0 at a point, even if no reduction leaves it out
	std::int32_t slot; // blockWidth · block + lane; none: overflow, or two prescribed bodies
	std::int32_t column;   // first column of its first point; those of the second follow
};

struct Range {
	std::int32_t begin = 0, end = 0;
};

/// The pairs of one colour, model and number of points in a section.
struct Row {
	std::int32_t pairs = 0, nextSlot = 0, firstBlock = 0, firstColumn = 0;
};

/// The pairs within a partition, or on some interfaces. One thread sweeps them.
struct Section {
	Range        chunks;  // in Layout::chunks
	Range        records; // of the bodies of a partition
	Range        pairs;   // in Layout::bySection
	Row          rows[Coloring::colors][models][2];
	std::int32_t prescribedRecords = 0; // each pair needs one per prescribed body
	std::int32_t nextRecord        = 0; // of these

	Row& row(int color, const PackedPair& pair)
	{
		return rows[color][int(pair.model)][pair.points - 1];
	}
};

struct Island {
	IslandShape  shape;
	bool         shared      = false; // several threads sweep it
	bool         halfRecords = false; // not small, and all its pairs are frictionless discs
	Range        pairs;               // in Layout::byIsland
	Range        overflowRecords;     // of the bodies with overflow pairs only
	Range        partitions, interfaces; // in Layout::sections
	Range        overflow;               // in Layout::overflow
};

class Layout {
public:
	/// Updates the layout. Returns false if nothing has changed.
	bool update(const ContactProblem&, const Reductions&, ThreadTeam&);

	/// Returns true if the stretch rate of the cell lags behind a sweep; false: it must not, or no
	/// cell stretches.
	bool cellLags() const { return cellLags_; }

	const std::vector<PackedPair>& pairs() const { return pairs_; } // in the order of the problem
	std::vector<PairBlock>&        pairBlocks() { return pairBlocks_; }
	const std::vector<Range>&      vacant() const { return vacant_; } // columns with empty slots
	int                            columns() const { return columns_; }
	int                            pointBlocks() const { return pointBlocks_; }
	BodyKind                       kind(int body) const { return bodyKind_[body]; }

	/// Number of half records: of bodies, then of prescribed bodies of sections and of empty slots.
	int records() const { return records_; }
	/// Record of a body. Order: island after island, partition after partition, then other bodies.
	int  record(int body) const { return record_[body]; }
	int  island(int body) const { return island_[body]; } // none: no contact moves it
	/// Island of a pair; none: two prescribed bodies.
	int  islandOf(const PackedPair& pair) const { return island_[movingBodies(pair)[0]]; }
	bool hasHalfRecord(int body) const
	{
		return island_[body] != none && islands_[island_[body]].halfRecords;
	}

	const std::vector<Island>&       islands() const { return islands_; }
	const std::vector<std::int32_t>& overflow() const { return overflow_; } // pairs, by island
	const std::vector<Section>&      sections() const { return sections_; }
	const std::vector<Chunk>&        chunks() const { return chunks_; }

	ModelSummary summary() const;

private:
	/// The properties of a point that the layout depends on.
	struct PointKey {
		std::int32_t body1, body2;
		Model        required;
		bool         crossesMovingCell, frictional;
	};

	bool  classifyBodies(const ContactProblem&);
	bool  findPairs(const ContactProblem&, ThreadTeam&);
	Model requiredModel(const ContactProblem&, const ContactPoint&) const;
	bool  moves(int body) const
	{
		return bodyKind_[body] != BodyKind::prescribed || !reductions_.fixed;
	}
	bool packable(const PackedPair&) const;
	void findIslands();
	/// The bodies of a pair; a prescribed one is replaced by its partner.
	Partitions::Edge movingBodies(const PackedPair& pair) const
	{
		return { moves(pair.body1) ? pair.body1 : pair.body2,
			moves(pair.body2) ? pair.body2 : pair.body1 };
	}
	void sortPairs();
	void chooseModels(Island&);
	void cut(Island&);
	int  sectionOf(const PackedPair&) const;
	void makeSections();
	void numberRecords();
	void color(Section&);
	void makeBlocks(Section&);
	void makeBlocks(Row&, Model, int points);
	void place(Section&);
	void listOverflow(Island&);
	int  appendRecords(int count);

	Reductions                    reductions_;
	bool                          stretches_ = false, cellLags_ = false; // of the cell
	std::vector<BodyKind>         bodyKind_;
	std::vector<PointKey>         pointKeys_;
	std::vector<PackedPair>       pairs_;
	std::vector<std::int32_t>     island_, record_; // of each body
	std::vector<Island>           islands_;
	Partitions                    partitions_;
	std::vector<Partitions::Edge> edges_;    // of one island
	std::vector<Section>          sections_; // partitions of all islands, then interfaces
	int                           partitionCount_ = 0;
	std::vector<std::int32_t>     byIsland_, bySection_, overflow_; // pairs
	std::vector<signed char>      color_;                           // of each pair
	std::vector<PairBlock>        pairBlocks_;
	std::vector<Chunk>            chunks_; // by section
	int                           columns_ = 0, pointBlocks_ = 0, records_ = 0;
	std::vector<Range>            vacant_;
	Coloring                      coloring_;
};

} // namespace rcr

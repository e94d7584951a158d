// Saved impulses, and changes of impulses and velocities of an island, for the error estimate and
// tests of divergence.
#include "sweep/packed_island.hpp"

namespace rcr {

/// Calls visit(p_n, p_t, 1/w_nn, number of the block) for the point blocks of a chunk; arrays of
/// one entry per lane. p_t is null without friction.
template <class Real, class Visit>
static void forEachImpulse(const PackedViewOf<Real>& view, const Chunk& chunk, Visit visit)
{
	const int columns = columnsOf(chunk.model);
	for (int k = 0; k < chunk.blocks * chunk.pointsPerPair; ++k) {
		ColumnOf<Real>* const      at = view.points + chunk.firstColumn + k * columns;
		const PointColumnsOf<Real> c(at);
		visit(c.pn(), hasFriction(chunk.model) ? NoLeverColumnsOf<Real>(at).pt() : nullptr,
		        c.inverseNn(), chunk.firstPointBlock + k);
	}
}

void PackedIsland::saveImpulses(int slot)
{
	Column* const to = packed_.savedPoint_[slot].data();
	forEachChunk([&](const Chunk& chunk, int) {
		inPrecision([&](const auto& view, const auto&) {
			forEachImpulse(view, chunk, [&](auto* pn, auto* pt, auto*, int block) {
				std::copy_n(pn, blockWidth, to[2 * block].of);
				if (pt) std::copy_n(pt, blockWidth, to[2 * block + 1].of);
			});
		});
	});
	for (int k = state_.overflow.begin; k < state_.overflow.end; ++k)
		packed_.savedOverflow_[slot][k] = packed_.overflow_[k].p;
}

std::vector<LocalVector> PackedProblem::savedImpulses(int slot) const
{
	std::vector<std::int32_t> firstPointBlock; // of each block of pairs
	for (const Chunk& chunk : layout_.chunks())
		for (int k = 0; k < chunk.blocks; ++k)
			firstPointBlock.push_back(chunk.firstPointBlock + k * chunk.pointsPerPair);
	std::vector<LocalVector> saved;
	for (const PackedPair& pair : layout_.pairs()) {
		saved.resize(pair.firstPoint + pair.points);
		if (pair.slot == none) continue;
		const int lane = pair.slot % blockWidth;
		for (int i = 0; i < pair.points; ++i) {
			const Column* at = &savedPoint_[slot][2 * (firstPointBlock[pair.slot / blockWidth] + i)];
			saved[pair.firstPoint + i] = { at[0].of[lane],
				hasFriction(pair.model) ? at[1].of[lane] : 0 };
		}
	}
	for (std::size_t k = 0; k < overflow_.size(); ++k)
		saved[overflow_[k].point] = savedOverflow_[slot][k];
	return saved;
}

PackedIsland::Change PackedIsland::changeSinceSaved(int slot)
{
	const Column* const saved = packed_.savedPoint_[slot].data();
	const auto          count = [&](Change& change, double square, double response) {
		change.square += square;
		if (response >= state_.norm.leastResponse) change.energy += response * square;
	};
	std::vector<Change> ofChunk(packed_.layout_.chunks().size());
	forEachChunk([&](const Chunk& chunk, int number) {
		Change change;
		inPrecision([&](const auto& view, const auto&) {
			forEachImpulse(view, chunk, [&](auto* pn, auto* pt, auto* scale, int block) {
				for (int lane = 0; lane < blockWidth; ++lane) {
					const double n = pn[lane] - saved[2 * block].of[lane];
					const double t = pt ? pt[lane] - saved[2 * block + 1].of[lane] : 0;
					count(change, n * n + t * t, scale[lane] > 0 ? 1 / double(scale[lane]) : 0);
				}
			});
		});
		ofChunk[number] = change;
	});
	Change total = sum(ofChunk);
	for (int k = state_.overflow.begin; k < state_.overflow.end; ++k) {
		const OverflowPoint& c = packed_.overflow_[k];
		count(total, square(c.p - packed_.savedOverflow_[slot][k]), c.ownNn);
	}
	return total;
}

double PackedIsland::changeEnergy() const
{
	const double* const free   = packed_.freeBody_.data()->of;
	const float* const  single = mixedPrecision_ ? singleView_.body : nullptr;
	double              energy = 0;
	const auto          add    = [&](const Range& records) {
		const int halves = island_.halfRecords ? 1 : 2;
		for (int k = records.begin; k < records.end; k += halves) {
			const InverseMass& m      = packed_.inverseMass_[k];
			const auto         square = [&](int number) {
				const std::uint32_t i = offsetOf(k) + number;
				const double        v = view_.body[i] + (single ? double(single[i]) : 0) - free[i];
				return v * v;
			};
			const double response = std::max(m.x, m.y);
			if (response > 0 && response < state_.norm.leastResponse) continue;
			if (m.x > 0) energy += square(record::x) / m.x;
			if (m.y > 0) energy += square(record::y) / m.y;
			if (halves == 2 && m.rotation > 0) energy += square(record::spin) / m.rotation;
		}
	};
	add(island_.overflowRecords);
	for (int k = island_.partitions.begin; k < island_.partitions.end; ++k)
		add(packed_.layout_.sections()[k].records);
	return energy;
}

} // namespace rcr

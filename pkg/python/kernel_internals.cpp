// Bindings of kernel internals for tests: error measures, layout, exact steps.
#include <pybind11/stl.h>

#include "exact/path_following.hpp"
#include "kernel_arrays.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"
#include "step/yield_bounds.hpp"
#include "sweep/packed_problem.hpp"

namespace rcr {

namespace {

	py::tuple yieldBoundsFrom(const Array& before, const py::kwargs& arrays)
	{
		Step step;
		step.problem = problemFrom(arrays);
		step.bodies.resize(step.problem.freeVelocity.size());
		const auto velocities = rowsFrom<PlanarVector>(before, "before", step.bodies.size());
		for (std::size_t id = 0; id < velocities.size(); ++id)
			step.bodies[id].velocity = velocities[id];
		for (const ContactPoint& c : step.problem.points) {
			double &radius1 = step.bodies[c.body1].radius, &radius2 = step.bodies[c.body2].radius;
			radius1         = std::max(radius1, norm(c.arm1));
			radius2         = std::max(radius2, norm(c.arm2));
		}
		ThreadTeam alone;
		const auto [driveSpeed, yielding] = yieldBoundsOf(step, alone);
		return py::make_tuple(driveSpeed, yielding.compliance, yielding.yieldImpulse);
	}

	// ---- linear algebra

	/// x of A x = b for a matrix of 3×3 blocks: diagonal (n, 3, 3), A_ij and A_ji of every pair (i,
	/// j), b (n, 3).
	Array solveBlocks(const std::vector<BlockLu::Pair>& pairs, const Array& diagonal,
	        const Array& upper, const Array& lower, const Array& b)
	{
		const int  n    = int(rowsOf(b));
		const auto copy = [](const Array& from, int k, Block& to) {
			for (int i = 0; i < 3; ++i)
				for (int j = 0; j < 3; ++j)
					to.entry[j][i] = from.at(k, i, j);
		};
		BlockLu matrix(n, pairs);
		matrix.setIdentity();
		for (int i = 0; i < n; ++i)
			copy(diagonal, i, matrix.diagonal(i));
		for (int k = 0; k < int(pairs.size()); ++k) {
			copy(upper, k, matrix.pairBlock(k, false));
			copy(lower, k, matrix.pairBlock(k, true));
		}
		if (!matrix.factor()) refuse("the matrix is singular: a diagonal block cannot be inverted");
		std::vector<BlockVector> x;
		for (const PlanarVector& row : rowsFrom<PlanarVector>(b, "b", n))
			x.push_back({ { row.x, row.y, row.rotation } });
		matrix.solve(x);
		std::vector<PlanarVector> result;
		for (const auto& [entry] : x)
			result.push_back({ entry[0], entry[1], entry[2] });
		return arrayOf(result);
	}

	// ---- proximal steps

	/// One proximal step about the impulses of the problem, with the same ρ at all points.
	py::dict followPathFrom(double rho, int maxPivots, const py::kwargs& arrays)
	{
		ContactProblem  problem = problemFrom(arrays);
		ProximalProblem proximal(problem);
		proximal.setReference(problem);
		for (std::size_t i = 0; i < proximal.size(); ++i)
			proximal.stiffness[i] = rho / proximal.contacts[i].wnn;
		const PathEnd end = followPath(proximal, maxPivots);
		proximal.store(problem);
		return py::dict("impulse"_a = arrayOf(problem.impulse), "complete"_a = end.complete,
		        "pivots"_a = end.pivots, "unstable"_a = end.unstable);
	}

	// ---- sweeps

	/// Rows of a layout. pairs: body 1, body 2, points, model, slot. islands: points, shared, half
	/// records, range of partitions, range of interfaces. sections: range of records. chunks: first
	/// block, blocks, points per pair, model, section. blocks1, blocks2: records of both sides.
	py::dict layoutOf(const std::vector<std::string>& reductions, const py::kwargs& arrays)
	{
		using Rows                   = std::vector<std::vector<std::int32_t>>;
		const ContactProblem problem = problemFrom(arrays);
		Layout               layout;
		ThreadTeam           alone;
		layout.update(problem, Reductions::of(reductions), alone);
		Rows pairs, islands, overflow, sections, chunks, blocks1, blocks2;
		for (const PackedPair& p : layout.pairs())
			pairs.push_back({ p.body1, p.body2, p.points, int(p.model), p.slot });
		for (const Island& island : layout.islands()) {
			islands.push_back({ island.shape.points, island.shared, island.halfRecords,
			                    island.partitions.begin, island.partitions.end,
			                    island.interfaces.begin, island.interfaces.end });
			overflow.emplace_back(layout.overflow().begin() + island.overflow.begin,
			        layout.overflow().begin() + island.overflow.end);
		}
		for (const Section& section : layout.sections()) {
			for (int k = section.chunks.begin; k < section.chunks.end; ++k) {
				const Chunk& c = layout.chunks()[k];
				chunks.push_back({ c.firstBlock, c.blocks, c.pointsPerPair, int(c.model),
				                   int(sections.size()) });
			}
			sections.push_back({ section.records.begin, section.records.end });
		}
		for (const PairBlock& block : layout.pairBlocks()) {
			blocks1.emplace_back(), blocks2.emplace_back();
			for (int lane = 0; lane < blockWidth; ++lane) {
				blocks1.back().push_back(recordOf(block.body1[lane]));
				blocks2.back().push_back(recordOf(block.body2[lane]));
			}
		}
		std::vector<std::int32_t> records;
		for (std::size_t body = 0; body < problem.inverseMass.size(); ++body)
			records.push_back(layout.record(int(body)));
		return py::dict("pairs"_a = pairs, "islands"_a = islands, "overflow"_a = overflow,
		        "sections"_a = sections, "chunks"_a = chunks, "blocks1"_a = blocks1,
		        "blocks2"_a = blocks2, "records"_a = records, "record_count"_a = layout.records());
	}

} // namespace

void bindInternals(py::module_& m)
{
	m.def(
	        "residual",
	        [](const py::kwargs& arrays) { return residualOf(problemFrom(arrays)); },
	        "Residual [-] of a problem; arrays as in `solve`.");
	m.def("yield_bounds", yieldBoundsFrom, "before"_a,
	        "(drive speed, compliance, yield impulse) of a problem, for previous velocities of the\n"
	        "bodies; arrays as in `solve`. The radius of a body is the longest of its arms.");
	m.def("solve_blocks", solveBlocks, "pairs"_a, "diagonal"_a, "upper"_a, "lower"_a, "b"_a,
	        "Solve A x = b, b (n, 3), for a sparse matrix of 3×3 blocks: diagonal (n, 3, 3), and\n"
	        "for pairs (i, j) of different rows, each once: upper = A_ij, lower = A_ji, both\n"
	        "(np, 3, 3). Raises ValueError if a diagonal block becomes singular.");
	m.def("follow_path", followPathFrom, "rho"_a, "max_pivots"_a,
	        "One proximal step about the impulses of a problem; arrays as in `solve`.\n"
	        "Returns a dict: impulse, complete, pivots, unstable.");
	m.def("layout", layoutOf, "reductions"_a, "Layout of a problem; arrays as in `solve`.");

	m.def("lane_width", [](int lanes) { return packedKernels(lanes).width; }, "lanes"_a,
	        "Vector width that runs for `lanes`, in contact points; 0: that of the processor.");
}

} // namespace rcr

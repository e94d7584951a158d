// rcr._kernel: the kernels for NumPy, without YADE. Angles in rad, everything else as in the kernels' headers.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <ctime>
#include <sstream>

#include "exact/block_lu.hpp"
#include "problem/coulomb.hpp"
#include "delassus/delassus_problem.hpp"
#include "geometry/deposition.hpp"
#include "exact/minimum_degree.hpp"
#include "problem/residual.hpp"
#include "geometry/shadow_overlap.hpp"
#include "problem/solver.hpp"
#include "watch/missed_steps.hpp"
#include "watch/squeeze.hpp"

namespace py = pybind11;
using namespace rcr;

namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids   = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// Time since it was made [s]: by the clock, and of the processor on this thread, which other programs do not lengthen.
class Stopwatch {
public:
	double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
	double processorSeconds() const { return processorNow() - processorStart_; }

private:
	using Clock = std::chrono::steady_clock;

	static double processorNow()
	{
		timespec now;
		clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
		return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
	}

	Clock::time_point start_          = Clock::now();
	double            processorStart_ = processorNow();
};

template <class A> void wantShape(const A& array, const char* name, py::ssize_t rows, py::ssize_t columns)
{
	const bool fits = columns == 1 ? array.ndim() == 1 && array.shape(0) == rows
	                               : array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns;
	if (fits) return;
	std::ostringstream message;
	message << name << " has shape (";
	for (py::ssize_t k = 0; k < array.ndim(); ++k)
		message << (k ? ", " : "") << array.shape(k);
	message << "); wanted (" << rows;
	if (columns > 1) message << ", " << columns;
	throw py::value_error(message.str() + ")");
}

py::dict toDict(const std::vector<Manifold>& manifolds)
{
	const py::ssize_t n = manifolds.size();
	Ids               count(n), type(n);
	Array             position({ n, py::ssize_t(2), py::ssize_t(2) }), normal({ n, py::ssize_t(2), py::ssize_t(2) });
	Array             gap({ n, py::ssize_t(2) });
	for (py::ssize_t i = 0; i < n; ++i) {
		count.mutable_at(i) = manifolds[i].count;
		type.mutable_at(i)  = int(manifolds[i].type);
		for (int k = 0; k < 2; ++k) {
			const ManifoldPoint& p          = manifolds[i].points[k];
			const bool           there      = k < manifolds[i].count;
			position.mutable_at(i, k, 0)    = there ? p.position.x : NAN;
			position.mutable_at(i, k, 1)    = there ? p.position.y : NAN;
			normal.mutable_at(i, k, 0)      = there ? p.normal.x : NAN;
			normal.mutable_at(i, k, 1)      = there ? p.normal.y : NAN;
			gap.mutable_at(i, k)            = there ? p.gap : NAN;
		}
	}
	return py::dict(py::arg("count") = count, py::arg("type") = type, py::arg("position") = position, py::arg("normal") = normal, py::arg("gap") = gap);
}

Pose    poseAt(const Array& a, py::ssize_t i) { return pose({ a.at(i, 0), a.at(i, 1) }, a.at(i, 2)); }
Stadium stadiumAt(const Array& a, py::ssize_t i) { return { a.at(i, 0), a.at(i, 1) }; }

py::dict overlapStadiums(const Array& stadium1, const Array& pose1, const Array& stadium2, const Array& pose2, double alertDistance)
{
	const py::ssize_t n = stadium1.ndim() ? stadium1.shape(0) : 0;
	wantShape(stadium1, "stadium1", n, 2), wantShape(pose1, "pose1", n, 3);
	wantShape(stadium2, "stadium2", n, 2), wantShape(pose2, "pose2", n, 3);
	std::vector<Manifold> result(n);
	for (py::ssize_t i = 0; i < n; ++i)
		result[i] = shadowOverlap(stadiumAt(stadium1, i), poseAt(pose1, i), stadiumAt(stadium2, i), poseAt(pose2, i), alertDistance);
	return toDict(result);
}

py::dict overlapWall(const Array& origin, const Array& normal, const Array& stadium, const Array& at, double alertDistance)
{
	const py::ssize_t n = stadium.ndim() ? stadium.shape(0) : 0;
	wantShape(origin, "origin", n, 2), wantShape(normal, "normal", n, 2), wantShape(stadium, "stadium", n, 2), wantShape(at, "pose", n, 3);
	std::vector<Manifold> result(n);
	for (py::ssize_t i = 0; i < n; ++i) {
		const HalfPlane wall { { origin.at(i, 0), origin.at(i, 1) }, { normal.at(i, 0), normal.at(i, 1) } };
		result[i] = shadowOverlap(wall, stadiumAt(stadium, i), poseAt(at, i), alertDistance);
	}
	return toDict(result);
}

py::dict overlapBox(const Array& halfExtent, const Array& boxPose, const Array& stadium, const Array& at, double alertDistance)
{
	const py::ssize_t n = stadium.ndim() ? stadium.shape(0) : 0;
	wantShape(halfExtent, "half_extent", n, 2), wantShape(boxPose, "box_pose", n, 3), wantShape(stadium, "stadium", n, 2), wantShape(at, "pose", n, 3);
	std::vector<Manifold> result(n);
	for (py::ssize_t i = 0; i < n; ++i)
		result[i] = shadowOverlap(Rectangle { { halfExtent.at(i, 0), halfExtent.at(i, 1) } }, poseAt(boxPose, i), stadiumAt(stadium, i), poseAt(at, i), alertDistance);
	return toDict(result);
}

/// A problem from arrays; every array is checked, and no id or number can be out of range.
ContactProblem problemFrom(
        const Array& inverseMass, const Array& freeVelocity, const Ids& bodies, const Array& normal, const Array& arm1, const Array& arm2,
        const Array& bias, const Array& friction, const Array& impulse)
{
	const py::ssize_t nb = inverseMass.ndim() ? inverseMass.shape(0) : 0, nc = bodies.ndim() ? bodies.shape(0) : 0;
	wantShape(inverseMass, "inverse_mass", nb, 3), wantShape(freeVelocity, "free_velocity", nb, 3);
	wantShape(bodies, "bodies", nc, 2), wantShape(normal, "normal", nc, 2), wantShape(arm1, "arm1", nc, 2), wantShape(arm2, "arm2", nc, 2);
	wantShape(bias, "bias", nc, 1), wantShape(friction, "friction", nc, 1), wantShape(impulse, "impulse", nc, 2);

	ContactProblem problem;
	for (py::ssize_t i = 0; i < nb; ++i) {
		problem.inverseMass.push_back({ inverseMass.at(i, 0), inverseMass.at(i, 1), inverseMass.at(i, 2) });
		problem.freeVelocity.push_back({ freeVelocity.at(i, 0), freeVelocity.at(i, 1), freeVelocity.at(i, 2) });
	}
	for (py::ssize_t k = 0; k < nc; ++k) {
		const auto vec = [k](const Array& a) { return Vec2 { a.at(k, 0), a.at(k, 1) }; };
		problem.points.push_back({ bodies.at(k, 0), bodies.at(k, 1), vec(normal), vec(arm1), vec(arm2), bias.at(k), friction.at(k) });
		problem.impulse.push_back({ impulse.at(k, 0), impulse.at(k, 1) });
	}
	checkProblem(problem);
	return problem;
}

py::dict solveArrays(
        const Array& inverseMass, const Array& freeVelocity, const Ids& bodies, const Array& normal, const Array& arm1, const Array& arm2,
        const Array& bias, const Array& friction, const Array& impulse, const std::string& solver, double tolerance, int maxIterations, int threads,
        int lanes, int checkInterval, int minIterations, int stallSweeps, double violation, double meanForceChange, double compliance,
        const std::vector<std::string>& reductions, Workspace* workspace)
{
	ContactProblem problem = problemFrom(inverseMass, freeVelocity, bodies, normal, arm1, arm2, bias, friction, impulse);
	Settings       settings;
	settings.tolerance     = tolerance;
	settings.maxIterations = maxIterations;
	settings.threads       = threads;
	settings.lanes         = lanes;
	settings.checkInterval = checkInterval;
	settings.minIterations = minIterations;
	settings.stallSweeps   = stallSweeps;
	settings.violation     = violation;
	settings.meanForceChange = meanForceChange;
	settings.compliance    = compliance;
	settings.reductions    = Reductions::of(reductions);
	Report report;
	double seconds, processorSeconds;
	{
		py::gil_scoped_release release;
		const Stopwatch        watch;
		report = workspace ? solve(problem, solver, settings, *workspace) : solve(problem, solver, settings);
		seconds = watch.seconds(), processorSeconds = watch.processorSeconds();
	}

	const py::ssize_t nc = problem.points.size(), nb = problem.inverseMass.size();
	Array             reaction({ nc, py::ssize_t(2) }), relative({ nc, py::ssize_t(2) }), velocity({ nb, py::ssize_t(3) });
	for (py::ssize_t k = 0; k < nc; ++k) {
		const ContactPoint& c = problem.points[k];
		const Impulse       u = relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
		reaction.mutable_at(k, 0) = problem.impulse[k].n, reaction.mutable_at(k, 1) = problem.impulse[k].t;
		relative.mutable_at(k, 0) = u.n, relative.mutable_at(k, 1) = u.t;
	}
	for (py::ssize_t i = 0; i < nb; ++i) {
		const Twist& v = problem.velocity[i];
		velocity.mutable_at(i, 0) = v.x, velocity.mutable_at(i, 1) = v.y, velocity.mutable_at(i, 2) = v.rotation;
	}
	return py::dict(
	        py::arg("impulse") = reaction, py::arg("relative_velocity") = relative, py::arg("velocity") = velocity,
	        py::arg("iterations") = report.iterations, py::arg("residual") = report.residual, py::arg("converged") = report.converged,
	        py::arg("violation") = report.violation, py::arg("yielded") = report.yielded, py::arg("taken") = report.taken, py::arg("closing") = report.closing, py::arg("work") = report.work, py::arg("seconds") = seconds,
	        py::arg("processor_seconds") = processorSeconds);
}

py::dict modelOf(const Workspace& workspace)
{
	const ModelSummary m = workspace.summary();
	return py::dict(
	        py::arg("bodies") = m.bodies, py::arg("rotations") = m.turning, py::arg("fixed") = m.fixed, py::arg("pairs") = m.pairs,
	        py::arg("points") = m.points, py::arg("unknowns") = m.unknowns(), py::arg("frictionless") = m.frictionalPoints == 0,
	        py::arg("islands") = m.islands, py::arg("layouts") = m.layouts);
}

py::dict solveDelassusArrays(
        const Ids& rowStart, const Ids& column, const Array& block, const Array& free, const Array& friction, const Array& impulse,
        const std::string& solver, double tolerance, int maxIterations, int checkInterval, int lanes)
{
	const py::ssize_t nc = free.ndim() ? free.shape(0) : 0, entries = column.ndim() ? column.shape(0) : 0;
	wantShape(free, "free", nc, 2), wantShape(friction, "friction", nc, 1), wantShape(impulse, "impulse", nc, 2);
	wantShape(rowStart, "row_start", nc + 1, 1), wantShape(column, "column", entries, 1), wantShape(block, "block", entries, 4);
	DelassusProblem problem;
	problem.rowStart.assign(rowStart.data(), rowStart.data() + nc + 1);
	problem.column.assign(column.data(), column.data() + entries);
	for (py::ssize_t e = 0; e < entries; ++e)
		problem.block.push_back({ block.at(e, 0), block.at(e, 1), block.at(e, 2), block.at(e, 3) });
	for (py::ssize_t k = 0; k < nc; ++k) {
		problem.free.push_back({ free.at(k, 0), free.at(k, 1) });
		problem.friction.push_back(friction.at(k));
		problem.impulse.push_back({ impulse.at(k, 0), impulse.at(k, 1) });
	}
	Settings settings;
	settings.tolerance     = tolerance;
	settings.maxIterations = maxIterations;
	settings.checkInterval = checkInterval;
	settings.lanes         = lanes;
	Report report;
	double seconds, processorSeconds;
	{
		py::gil_scoped_release release;
		const Stopwatch        watch;
		report  = solve(problem, solver, settings);
		seconds = watch.seconds(), processorSeconds = watch.processorSeconds();
	}
	Array        reaction({ nc, py::ssize_t(2) }), velocity({ nc, py::ssize_t(2) });
	for (py::ssize_t k = 0; k < nc; ++k) {
		reaction.mutable_at(k, 0) = problem.impulse[k].n, reaction.mutable_at(k, 1) = problem.impulse[k].t;
		velocity.mutable_at(k, 0) = problem.velocity[k].n, velocity.mutable_at(k, 1) = problem.velocity[k].t;
	}
	return py::dict(
	        py::arg("impulse") = reaction, py::arg("relative_velocity") = velocity, py::arg("iterations") = report.iterations,
	        py::arg("residual") = report.residual, py::arg("converged") = report.converged, py::arg("seconds") = seconds,
	        py::arg("processor_seconds") = processorSeconds);
}

/// x of A x = b for a matrix of 3×3 blocks: diagonal (n, 3, 3), A_ij and A_ji of every pair (i, j), b (n, 3).
Array solveBlocks(const Ids& pairs, const Array& diagonal, const Array& upper, const Array& lower, const Array& b)
{
	const py::ssize_t n = b.ndim() ? b.shape(0) : 0, count = pairs.ndim() ? pairs.shape(0) : 0;
	wantShape(b, "b", n, 3), wantShape(pairs, "pairs", count, 2);
	const auto copy = [](const Array& from, py::ssize_t k, Block& to) {
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				to.entry[j][i] = from.at(k, i, j);
	};
	std::vector<BlockLu::Pair> list;
	for (py::ssize_t k = 0; k < count; ++k)
		list.emplace_back(pairs.at(k, 0), pairs.at(k, 1));
	BlockLu matrix(static_cast<std::int32_t>(n), list);
	matrix.setIdentity();
	for (py::ssize_t i = 0; i < n; ++i)
		copy(diagonal, i, matrix.diagonal(i));
	for (py::ssize_t k = 0; k < count; ++k) {
		copy(upper, k, matrix.pairBlock(k, false));
		copy(lower, k, matrix.pairBlock(k, true));
	}
	if (!matrix.factor()) throw py::value_error("the matrix is singular: a diagonal block cannot be inverted");
	std::vector<BlockVector> x(n);
	for (py::ssize_t i = 0; i < n; ++i)
		for (int j = 0; j < 3; ++j)
			x[i].entry[j] = b.at(i, j);
	matrix.solve(x);
	Array result({ n, py::ssize_t(3) });
	for (py::ssize_t i = 0; i < n; ++i)
		for (int j = 0; j < 3; ++j)
			result.mutable_at(i, j) = x[i].entry[j];
	return result;
}

std::vector<std::int32_t> orderOf(std::int32_t size, const std::vector<BlockLu::Pair>& pairs)
{
	std::vector<std::vector<std::int32_t>> adjacent(size);
	for (const BlockLu::Pair& pair : pairs) {
		adjacent.at(pair.first).push_back(pair.second);
		adjacent.at(pair.second).push_back(pair.first);
	}
	std::vector<std::int32_t> begin { 0 }, neighbours;
	for (const auto& list : adjacent) {
		neighbours.insert(neighbours.end(), list.begin(), list.end());
		begin.push_back(static_cast<std::int32_t>(neighbours.size()));
	}
	return minimumDegreeOrder(begin, neighbours);
}

Array depositArrays(const Array& radii, double width)
{
	const py::ssize_t n = radii.ndim() ? radii.shape(0) : 0;
	wantShape(radii, "radii", n, 1);
	for (py::ssize_t i = 0; i < n; ++i)
		if (!(radii.at(i) > 0 && 2 * radii.at(i) <= width && std::isfinite(width))) {
			std::ostringstream message;
			message << "radii[" << i << "] = " << radii.at(i) << " in a box of width " << width << "; wanted 0 < 2 radius <= width";
			throw py::value_error(message.str());
		}
	const std::vector<Vec2> centers = deposit({ radii.data(), radii.data() + n }, width);
	Array                   result({ n, py::ssize_t(2) });
	for (py::ssize_t i = 0; i < n; ++i)
		result.mutable_at(i, 0) = centers[i].x, result.mutable_at(i, 1) = centers[i].y;
	return result;
}

} // namespace

PYBIND11_MODULE(_kernel, m)
{
	m.doc() = "Kernels of yade-rcr for NumPy: stadium, shadow overlap, contact problem. They need no YADE.";

	m.def("area", [](double a, double r) { return area(Stadium { a, r }); }, py::arg("half_length"), py::arg("cap_radius"), "Area of a stadium [m²].");
	m.def("polar_moment", [](double a, double r) { return polarMoment(Stadium { a, r }); }, py::arg("half_length"), py::arg("cap_radius"),
	      "∫ |x|² dA of a stadium about its centre [m⁴].");
	m.def("half_extent", [](double a, double r, double angle) {
		const Vec2 h = halfExtent(Stadium { a, r }, pose({}, angle).axis);
		return py::make_tuple(h.x, h.y);
	}, py::arg("half_length"), py::arg("cap_radius"), py::arg("angle"), "Half widths of the axis-aligned bounding box [m].");
	m.def("support", [](double a, double r, double angle, double direction) {
		const Vec2 p = support(Stadium { a, r }, pose({}, angle), pose({}, direction).axis);
		return py::make_tuple(p.x, p.y);
	}, py::arg("half_length"), py::arg("cap_radius"), py::arg("angle"), py::arg("direction"), "Point of a stadium farthest along a direction [m].");

	const char* manifold = "Manifolds of N pairs: dict of count (N,), type (N,) 0 cc, 1 cs, 2 ss, 3 wall, position, normal (N, 2, 2), gap (N, 2) [m];\n"
	                       "unused points are NaN. A stadium is (half length, cap radius), a pose (x, y, angle).";
	m.def("overlap_stadiums", overlapStadiums, py::arg("stadium1"), py::arg("pose1"), py::arg("stadium2"), py::arg("pose2"), py::arg("alert_distance"), manifold);
	m.def("overlap_wall", overlapWall, py::arg("origin"), py::arg("normal"), py::arg("stadium"), py::arg("pose"), py::arg("alert_distance"), manifold);
	m.def("overlap_box", overlapBox, py::arg("half_extent"), py::arg("box_pose"), py::arg("stadium"), py::arg("pose"), py::arg("alert_distance"), manifold);

	m.def("deposit", depositArrays, py::arg("radii"), py::arg("width"),
	      "Centres (n, 2) [m] of discs dropped one after the other to the lowest place of the free surface, in 0 <= x <= width, y >= 0.");

	m.def("solve_coulomb", [](double nn, double nt, double tt, double gn, double gt, double friction) {
		const Impulse p = solveCoulomb({ nn, nt, tt }, gn, gt, friction);
		return py::make_tuple(p.n, p.t);
	}, py::arg("w_nn"), py::arg("w_nt"), py::arg("w_tt"), py::arg("g_n"), py::arg("g_t"), py::arg("friction"), "Impulse (p_n, p_t) of one contact point.");
	m.def("project_cone", [](double n, double t, double friction) {
		const Impulse p = projectCone({ n, t }, friction);
		return py::make_tuple(p.n, p.t);
	}, py::arg("n"), py::arg("t"), py::arg("friction"), "Projection onto |t| ≤ µ n.");

	m.def("solve_blocks", solveBlocks, py::arg("pairs"), py::arg("diagonal"), py::arg("upper"), py::arg("lower"), py::arg("b"),
	      "Solve A x = b (n, 3) for a sparse matrix of 3×3 blocks: diagonal (n, 3, 3), and for each of the pairs (i, j) (np, 2) upper = A_ij and\n"
	      "lower = A_ji (np, 3, 3). Raises ValueError where a diagonal block becomes singular.");
	m.def("minimum_degree_order", orderOf, py::arg("size"), py::arg("pairs"), "Order in which to eliminate the nodes of a graph with these edges.");

	py::class_<Workspace>(m, "Workspace", "What the sweep solvers keep from one problem to the next: give the same one for each step of a simulation.")
	        .def(py::init<>())
	        .def_property_readonly("model", modelOf, "What the sweeps made of the last problem, as ContactDynamics.model tells it.")
	        .def_property_readonly("layouts", &Workspace::layouts, "How often a problem had other pairs or kinds of bodies than the one before.");

	m.def("solver_names", solverNames, "Names that `solve` takes.");
	m.def("solve", solveArrays, py::arg("inverse_mass"), py::arg("free_velocity"), py::arg("bodies"), py::arg("normal"), py::arg("arm1"), py::arg("arm2"),
	      py::arg("bias"), py::arg("friction"), py::arg("impulse"), py::arg("solver") = "auto", py::arg("tolerance") = 1e-4,
	      py::arg("max_iterations") = 1000, py::arg("threads") = 1, py::arg("lanes") = 0, py::arg("check_interval") = 10, py::arg("min_iterations") = 0,
	      py::arg("stall_sweeps") = 0, py::arg("violation") = Settings().violation, py::arg("mean_force_change") = 0, py::arg("compliance") = 0,
	      py::arg("reductions") = Reductions::names(), py::arg("workspace") = nullptr,
	      "Solve one contact problem (contact_problem.hpp): dict of impulse (nc, 2) [N s], relative_velocity (nc, 2) and velocity (nb, 3) [m/s, 1/s],\n"
	      "iterations, residual, converged, violation, yielded, taken [J/m], closing [m/s], work (sweeps × points), seconds, processor_seconds (of the calling thread); settings as in solver.hpp.\n"
	      "Raises ValueError on arrays that do not fit together.");
	m.def("solve_delassus", solveDelassusArrays, py::arg("row_start"), py::arg("column"), py::arg("block"), py::arg("free"), py::arg("friction"),
	      py::arg("impulse"), py::arg("solver") = "auto", py::arg("tolerance") = 1e-4, py::arg("max_iterations") = 1000, py::arg("check_interval") = 10,
	      py::arg("lanes") = 0,
	      "Solve one problem given by W and q (delassus_problem.hpp), W in rows of blocks: row_start (nc + 1,), column (nb,), block (nb, 4) as\n"
	      "(nn, nt, tn, tt) [1/kg], free = q (nc, 2) [m/s]. Dict of impulse, relative_velocity (nc, 2), iterations, residual, converged, seconds,\n"
	      "processor_seconds.");
	py::class_<Squeeze>(m, "Squeeze", "Grains that are squeezed on and on (watch/squeeze.hpp).")
	        .def(py::init<>())
	        .def_readwrite("grown", &Squeeze::grown)
	        .def_readwrite("deepest", &Squeeze::deepest)
	        .def_readonly_static("crushed", &Squeeze::crushed)
	        .def_readonly_static("patience", &Squeeze::patience)
	        .def("goes_on", &Squeeze::goesOn, py::arg("overlap"), "After a step, with its deepest overlap over R₁ + R₂: whether it is to be told.");
	py::class_<MissedSteps>(m, "MissedSteps", "Steps that missed the tolerance, and whether they did harm (watch/missed_steps.hpp).")
	        .def(py::init<>())
	        .def_readonly("steps", &MissedSteps::steps)
	        .def_readonly("missed", &MissedSteps::missed)
	        .def_readonly("yielded", &MissedSteps::yielded)
	        .def_readonly("deepest", &MissedSteps::deepest)
	        .def_property_readonly("share", &MissedSteps::share)
	        .def("count", &MissedSteps::count, py::arg("missed"), py::arg("yielded"), py::arg("overlap"), "After a step: whether there is something to tell.")
	        .def("message", &MissedSteps::message);
}

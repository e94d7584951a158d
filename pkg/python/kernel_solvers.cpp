// Bindings of the solvers: problems of bodies, problems of W and q, and the problem of one point.
#include <pybind11/stl.h>

#include <array>

#include "delassus/delassus_problem.hpp"
#include "kernel_arrays.hpp"
#include "problem/coulomb.hpp"
#include "problem/solver.hpp"

namespace rcr {

namespace {

	py::dict solveArrays(
	        const Array& inverseMass, const Array& freeVelocity, const py::object& bodies,
	        const Array& normal, const Array& arm1, const Array& arm2, const Array& bias,
	        const Array& friction, const Array& impulse, const std::string& solver,
	        double tolerance, int maxIterations, int threads, int lanes, int checkInterval,
	        int minIterations, int stallSweeps, double kinematicTolerance, double meanForceChange,
	        double yieldCompliance, double yieldImpulse, const std::vector<std::string>& reductions,
	        Workspace* workspace, const py::object& drift, const py::object& shift,
	        const py::object& inverseStretchMass, const py::object& recovery)
	{
		ContactProblem problem = problemFrom(
		        inverseMass, freeVelocity, bodies, normal, arm1, arm2, bias, friction, impulse,
		        { drift, shift, inverseStretchMass, recovery });
		Settings settings = stopSettings(
		        tolerance, kinematicTolerance, meanForceChange, checkInterval, minIterations,
		        maxIterations, stallSweeps);
		settings.threads         = threads;
		settings.lanes           = lanes;
		settings.yieldCompliance = yieldCompliance;
		settings.yieldImpulse    = yieldImpulse;
		settings.reductions      = Reductions::of(reductions);
		Workspace own;
		Report    report;
		double    seconds, processorSeconds;
		{
			py::gil_scoped_release release;
			const Stopwatch        watch;
			report  = solve(problem, solver, settings, workspace ? *workspace : own);
			seconds = watch.seconds(), processorSeconds = watch.processorSeconds();
		}

		std::vector<Impulse> relative;
		for (const ContactPoint& c : problem.points)
			relative.push_back(relativeVelocity(problem, c));
		return py::dict(
		        py::arg("impulse")           = arrayOf(problem.impulse),
		        py::arg("relative_velocity") = arrayOf(relative),
		        py::arg("velocity")          = arrayOf(problem.velocity),
		        py::arg("stretch")           = py::make_tuple(problem.stretch.x, problem.stretch.y),
		        py::arg("iterations") = report.iterations, py::arg("residual") = report.residual,
		        py::arg("converged")       = report.converged,
		        py::arg("kinematic_error") = report.kinematicError,
		        py::arg("yielded") = report.yielded, py::arg("dissipated") = report.dissipated,
		        py::arg("closing_speed")  = report.closingSpeed,
		        py::arg("impulse_growth") = report.impulseGrowth, py::arg("work") = report.work,
		        py::arg("seconds") = seconds, py::arg("processor_seconds") = processorSeconds);
	}

	py::dict modelOf(const Workspace& workspace)
	{
		const ModelSummary m = workspace.summary();
		return py::dict(
		        py::arg("bodies") = m.bodies, py::arg("rotations") = m.rotating,
		        py::arg("fixed") = m.fixed, py::arg("pairs") = m.pairs,
		        py::arg("points") = m.points, py::arg("unknowns") = m.unknowns(),
		        py::arg("frictionless") = m.frictionalPoints == 0, py::arg("islands") = m.islands,
		        py::arg("layouts") = m.layouts);
	}

	py::dict solveDelassusArrays(
	        const py::object& rowStart, const py::object& column, const Array& block,
	        const Array& free, const Array& friction, const Array& impulse,
	        const std::string& solver, double tolerance, int maxIterations, int checkInterval)
	{
		DelassusProblem problem = delassusFrom(rowStart, column, block, free, friction, impulse);
		Settings        settings;
		settings.tolerance     = tolerance;
		settings.maxIterations = maxIterations;
		settings.checkInterval = checkInterval;
		Report report;
		double seconds, processorSeconds;
		{
			py::gil_scoped_release release;
			const Stopwatch        watch;
			report  = solve(problem, solver, settings);
			seconds = watch.seconds(), processorSeconds = watch.processorSeconds();
		}
		return py::dict(
		        py::arg("impulse")           = arrayOf(problem.impulse),
		        py::arg("relative_velocity") = arrayOf(problem.velocity),
		        py::arg("iterations") = report.iterations, py::arg("residual") = report.residual,
		        py::arg("converged") = report.converged, py::arg("seconds") = seconds,
		        py::arg("processor_seconds") = processorSeconds);
	}

} // namespace

void bindSolvers(py::module_& m)
{
	m.def(
	        "solve_coulomb",
	        [](double nn, double nt, double tt, double gn, double gt, double friction) {
		        const Impulse p = solveCoulomb({ nn, nt, tt }, gn, gt, friction);
		        return py::make_tuple(p.n, p.t);
	        },
	        py::arg("w_nn"), py::arg("w_nt"), py::arg("w_tt"), py::arg("g_n"), py::arg("g_t"),
	        py::arg("friction"), "Impulse (p_n, p_t) of one contact point.");
	m.def(
	        "passive_restitution_factor",
	        [](double nn, double nt, double tt, const std::array<double, 2>& p,
	           const std::array<double, 2>& before, const std::array<double, 2>& after, double bias,
	           double friction) {
		        return passiveRestitutionFactor(
		                { nn, nt, tt }, { p[0], p[1] }, { before[0], before[1] },
		                { after[0], after[1] }, bias, friction);
	        },
	        py::arg("w_nn"), py::arg("w_nt"), py::arg("w_tt"), py::arg("impulse"),
	        py::arg("before"), py::arg("after"), py::arg("bias"), py::arg("friction"),
	        "Largest factor of the restitution `bias` < 0 for which one point adds no energy [-].");
	m.def(
	        "project_cone",
	        [](double n, double t, double friction) {
		        const Impulse p = projectCone({ n, t }, friction);
		        return py::make_tuple(p.n, p.t);
	        },
	        py::arg("n"), py::arg("t"), py::arg("friction"), "Projection onto |t| ≤ µ n.");

	py::class_<Workspace>(
	        m, "Workspace",
	        "Data of the sweep solvers between problems. Use one for all steps of a simulation.")
	        .def(py::init<>())
	        .def_property_readonly(
	                "model", modelOf, "Model of the last problem, as in ContactDynamics.model.");

	m.def("solver_names", solverNames, "Names of the solvers of `solve`.");
	m.def("solve", solveArrays, py::arg("inverse_mass"), py::arg("free_velocity"),
	      py::arg("bodies"), py::arg("normal"), py::arg("arm1"), py::arg("arm2"), py::arg("bias"),
	      py::arg("friction"), py::arg("impulse"), py::arg("solver") = "auto",
	      py::arg("tolerance") = 1e-4, py::arg("max_iterations") = 1000, py::arg("threads") = 1,
	      py::arg("lanes") = 0, py::arg("check_interval") = 10, py::arg("min_iterations") = 0,
	      py::arg("stall_sweeps")        = 0,
	      py::arg("kinematic_tolerance") = Settings().kinematicTolerance,
	      py::arg("mean_force_change") = 0, py::arg("yield_compliance") = 0,
	      py::arg("yield_impulse") = Settings().yieldImpulse,
	      py::arg("reductions") = Reductions::names(), py::arg("workspace") = nullptr,
	      py::arg("drift") = py::none(), py::arg("shift") = py::none(),
	      py::arg("inverse_stretch_mass") = py::none(), py::arg("recovery") = py::none(),
	      "Solve one contact problem (contact_problem.hpp); settings as in solver.hpp.\n"
	      "\n"
	      "Returns a dict: impulse (nc, 2) [N s], relative_velocity (nc, 2) [m/s], velocity\n"
	      "(nb, 3) [m/s, 1/s], stretch (2,) [1/s], iterations, residual [-], converged,\n"
	      "kinematic_error [-], yielded, dissipated [J/m], closing_speed [m/s], impulse_growth\n"
	      "over the last 100 sweeps [-], work (sweeps × points), seconds, processor_seconds (of\n"
	      "the calling thread).\n"
	      "Raises ValueError for arrays of inconsistent shapes and settings out of range.");
	m.def("solve_delassus", solveDelassusArrays, py::arg("row_start"), py::arg("column"),
	      py::arg("block"), py::arg("free"), py::arg("friction"), py::arg("impulse"),
	      py::arg("solver") = "auto", py::arg("tolerance") = 1e-4, py::arg("max_iterations") = 1000,
	      py::arg("check_interval") = 10,
	      "Solve one problem of W and q (delassus_problem.hpp).\n"
	      "\n"
	      "W is given by rows of blocks: row_start (nc + 1,), column (nb,), block (nb, 4) as\n"
	      "(nn, nt, tn, tt) [1/kg]; free = q (nc, 2) [m/s]. Returns a dict: impulse (nc, 2)\n"
	      "[N s], relative_velocity (nc, 2) [m/s], iterations, residual [-], converged, seconds,\n"
	      "processor_seconds.");
}

} // namespace rcr

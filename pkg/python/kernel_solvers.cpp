// Bindings of the solvers: problems of bodies, problems of W and q, and the problem of one point.
#include <pybind11/stl.h>

#include <array>
#include <ctime>

#include "delassus/delassus_problem.hpp"
#include "kernel_arrays.hpp"
#include "problem/coulomb.hpp"

namespace rcr {

namespace {

	/// Time of a clock [s].
	double now(clockid_t clock)
	{
		timespec time;
		clock_gettime(clock, &time);
		return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
	}

	/// Runs a solver without Python's lock. Adds its report and times to the results.
	template <class Solve> Report timed(py::dict& results, Solve solve)
	{
		Report report;
		double seconds, processorSeconds;
		{
			const py::gil_scoped_release release;
			const double wall = now(CLOCK_MONOTONIC), processor = now(CLOCK_THREAD_CPUTIME_ID);
			report           = solve();
			seconds          = now(CLOCK_MONOTONIC) - wall;
			processorSeconds = now(CLOCK_THREAD_CPUTIME_ID) - processor;
		}
		results["iterations"]        = report.iterations;
		results["residual"]          = report.residual;
		results["converged"]         = report.converged;
		results["seconds"]           = seconds;
		results["processor_seconds"] = processorSeconds;
		return report;
	}

	py::dict solveArrays(const std::string& solver, double tolerance, int maxIterations,
	        int threads, int lanes, int checkInterval, int minIterations, int stallSweeps,
	        double accuracy, double meanForceChange, double yieldCompliance,
	        double yieldImpulse, const std::vector<std::string>& reductions, Workspace* workspace,
	        const py::kwargs& arrays)
	{
		ContactProblem problem  = problemFrom(arrays);
		Settings       settings = stopSettings(
                tolerance, accuracy, meanForceChange, checkInterval, minIterations,
                maxIterations, stallSweeps);
		settings.threads    = threads;
		settings.lanes      = lanes;
		settings.yielding   = { yieldCompliance, 0, yieldImpulse };
		settings.undriven   = { yieldCompliance };
		settings.reductions = Reductions::of(reductions);
		Workspace    own;
		py::dict     results;
		const Report report = timed(results, [&] {
			return solve(problem, solver, settings, workspace ? *workspace : own);
		});

		std::vector<LocalVector> relative;
		for (const ContactPoint& c : problem.points)
			relative.push_back(relativeVelocity(problem, c));
		results["impulse"]           = arrayOf(problem.impulse);
		results["relative_velocity"] = arrayOf(relative);
		if (!problem.rollingImpulse.empty())
			results["rolling_impulse"] = py::array_t<double>(
			        py::ssize_t(problem.rollingImpulse.size()), problem.rollingImpulse.data());
		results["velocity"]          = arrayOf(problem.velocity);
		results["stretch_rate"]      = py::make_tuple(problem.stretchRate.x, problem.stretchRate.y);
		results["error_estimate"]    = report.errorEstimate;
		results["yielded"]           = report.yielded;
		results["yielded_bodies"]
		        = std::vector<bool>(problem.yielded.begin(), problem.yielded.end());
		results["impulse_growth"]    = report.impulseGrowth;
		results["work"]              = report.work;
		return results;
	}

	py::dict modelOf(const Workspace& workspace)
	{
		py::dict model;
		workspace.summary().forEachEntry(
		        [&](const char* name, auto value) { model[name] = value; });
		return model;
	}

	/// Checks the shapes; the solver checks the values.
	py::dict solveDelassusArrays(const py::object& givenRowStart, const py::object& givenColumn,
	        const Array& block, const Array& free, const Array& friction, const Array& impulse,
	        const std::string& solver, double tolerance, int maxIterations, int checkInterval)
	{
		const Ids rowStart   = idsFrom(givenRowStart, "row_start"),
		          column     = idsFrom(givenColumn, "column");
		const py::ssize_t nc = rowsOf(free), entries = rowsOf(column);
		requireShape(rowStart, "row_start", { nc + 1 });
		requireShape(column, "column", { entries });
		DelassusProblem problem { { rowStart.data(), rowStart.data() + nc + 1 },
			{ column.data(), column.data() + entries },
			rowsFrom<DelassusBlock>(block, "block", entries),
			rowsFrom<LocalVector>(free, "free_velocity", nc),
			rowsFrom<double>(friction, "friction", nc),
			rowsFrom<LocalVector>(impulse, "impulse", nc), {} };
		Settings settings;
		settings.tolerance     = tolerance;
		settings.maxIterations = maxIterations;
		settings.checkInterval = checkInterval;
		py::dict results;
		timed(results, [&] { return solve(problem, solver, settings); });
		results["impulse"]           = arrayOf(problem.impulse);
		results["relative_velocity"] = arrayOf(problem.velocity);
		return results;
	}

} // namespace

void bindSolvers(py::module_& m)
{
	m.def(
	        "solve_coulomb",
	        [](double nn, double nt, double tt, double gn, double gt, double friction) {
		        const LocalVector p = solveCoulomb({ nn, nt, tt }, gn, gt, friction);
		        return py::make_tuple(p.n, p.t);
	        },
	        "w_nn"_a, "w_nt"_a, "w_tt"_a, "g_n"_a, "g_t"_a, "friction"_a,
	        "Impulse (p_n, p_t) of one contact point.");
	m.def(
	        "passive_restitution_factor",
	        [](double nn, double nt, double tt, const std::array<double, 2>& p,
	           const std::array<double, 2>& before, const std::array<double, 2>& after, double bias,
	           double friction) {
		        return passiveRestitutionFactor(
		                { nn, nt, tt }, { p[0], p[1] }, { before[0], before[1] },
		                { after[0], after[1] }, bias, friction);
	        },
	        "w_nn"_a, "w_nt"_a, "w_tt"_a, "impulse"_a, "before"_a, "after"_a, "bias"_a, "friction"_a,
	        "Largest factor of the restitution `bias` < 0 for which one point adds no energy [-].");
	m.def(
	        "project_cone",
	        [](double n, double t, double friction) {
		        const LocalVector p = projectCone({ n, t }, friction);
		        return py::make_tuple(p.n, p.t);
	        },
	        "n"_a, "t"_a, "friction"_a, "Projection onto |t| ≤ µ n.");

	py::class_<Workspace>(m, "Workspace",
	        "Data of the sweep solvers between problems. Use one for all steps of a simulation.")
	        .def(py::init<>())
	        .def_property_readonly("model", modelOf,
	                "Model of the last problem, as in ContactDynamics.model.");

	m.def("solver_names", solverNames, "Names of the solvers of `solve`.");
	m.attr("solution_spread") = solutionSpread; // error_estimate.hpp
	m.def("solve", solveArrays, "solver"_a = "auto", "tolerance"_a = 1e-4,
	        "max_iterations"_a = 1000, "threads"_a = 1, "lanes"_a = 0, "check_interval"_a = 10,
	        "min_iterations"_a = 0, "stall_sweeps"_a = 0,
	        "accuracy"_a = Settings().accuracy, "mean_force_change"_a = 0,
	        "yield_compliance"_a = 0, "yield_impulse"_a = Yielding().yieldImpulse,
	        "reductions"_a = Reductions::names(), "workspace"_a = nullptr,
	        "Solve one contact problem (contact_problem.hpp); settings as in solver.hpp.\n"
	        "\n"
	        "Arrays by keyword: inverse_mass and free_velocity (nb, 3), bodies, normal, arm1, arm2\n"
	        "and impulse (nc, 2), bias and friction (nc,); optional: drift and shift (nc, 2),\n"
	        "inverse_stretch_mass (2,), place (nb, 2), recovery_bias (nc,), yielded (nb,),\n"
	        "pull (nc,) [N s], rolling_friction (nc,) [-], rolling_length (nc,) [m],\n"
	        "rolling_impulse (nc,) [N s].\n"
	        "\n"
	        "Returns a dict: impulse (nc, 2) [N s], relative_velocity (nc, 2) [m/s], velocity\n"
	        "(nb, 3) [m/s, 1/s], rolling_impulse (nc,) if rolling_friction is given, stretch_rate (2,) [1/s], iterations, residual [-], converged,\n"
	        "error_estimate [-], yielded, yielded_bodies (list), impulse_growth over the last\n"
	        "100 sweeps [-], work (sweeps × points), seconds, processor_seconds (of this thread).\n"
	        "Raises ValueError for arrays of inconsistent shapes and settings out of range.");
	m.def("solve_delassus", solveDelassusArrays, "row_start"_a, "column"_a, "block"_a,
	        "free_velocity"_a, "friction"_a, "impulse"_a, "solver"_a = "auto", "tolerance"_a = 1e-4,
	        "max_iterations"_a = 1000, "check_interval"_a = 10,
	        "Solve one problem of W and q (delassus_problem.hpp).\n"
	        "\n"
	        "W is given by rows of blocks: row_start (nc + 1,), column (nb,), block (nb, 4) as\n"
	        "(nn, nt, tn, tt) [1/kg]; free_velocity = q (nc, 2) [m/s]. Returns a dict: impulse\n"
	        "(nc, 2) [N s], relative_velocity (nc, 2) [m/s], iterations, residual [-], converged,\n"
	        "seconds, processor_seconds.");
}

} // namespace rcr

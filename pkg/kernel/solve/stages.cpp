#include "solve/stages.hpp"

#include <numeric>

#include "solve/solve_auto.hpp"
#include "solve/yield_tests.hpp"

namespace rcr {

constexpr double exactBelow     = 1e-6; // residual below which exact steps are faster [-]
constexpr int    sweepsFromZero = 100;  // they replace impulses that would add energy

static bool frictionless(const ContactProblem& problem)
{
	const auto isFrictionless = [](const ContactPoint& c) { return c.friction == 0 && !c.rolls(); };
	return std::all_of(problem.points.begin(), problem.points.end(), isFrictionless);
}

/// Returns true if `auto` runs exact steps as `exact` does.
static bool isTight(const ContactProblem& problem, const Settings& settings)
{
	return settings.tolerance > 0 && settings.tolerance < exactBelow && !frictionless(problem);
}

Report sweepTogether(ContactProblem& problem, const std::string& solver, const Settings& settings,
        Workspace& workspace)
{
	if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
	if (solver == "sor") return solveNlgs(problem, settings, workspace, sorRelaxation);
	if (solver == "nesterov") return solveNesterov(problem, settings, workspace);
	if (solver == "exact" || isTight(problem, settings))
		return sweepForExactSteps(problem, settings, workspace);
	return solveNesterov(problem, settings, workspace, firstSweepsOfAuto);
}

bool takesExactSteps(const std::string& solver, const Settings& settings)
{
	return solver == "exact" || (solver == "auto" && settings.tolerance > 0);
}

namespace {

	enum class State {
		swept,      // with all islands together
		unsolved,   // misses its limits
		solved,     // meets its limits
		infeasible, // has no solution: contacts must yield
		ended,      // nothing is left to do
	};

	struct Island {
		ContactProblem&    problem;
		const std::string& solver;
		Settings           settings; // of the whole problem, then of the island
		Workspace&         workspace;
		Report             report;
		std::vector<LocalVector> before; // impulses before the last probeSweeps; empty: unknown
		State              state = State::swept;

		Settings remaining() const
		{
			Settings left      = settings;
			left.maxIterations = std::max(settings.maxIterations - report.iterations, 0);
			return left;
		}
		bool takesExactSteps() const
		{
			return rcr::takesExactSteps(solver, settings);
		}
		void setSolved() { state = report.converged ? State::solved : State::unsolved; }
		void sweepAgain()
		{
			report = sweepTogether(problem, solver, remaining(), workspace).plusCostOf(report);
			before.clear();
		}
	};

	/// The bounds of a drive elsewhere do not hold in an island without one. If it yielded by them
	/// in an earlier pass, it has had few sweeps and is swept again.
	void useOwnDrive(Island& island)
	{
		Settings&  own      = island.settings;
		const bool mayYield = own.mayYield();
		if (mayYield && !island.problem.stretches() && !isDriven(island.problem)) {
			const auto& points = island.problem.points;
			own.yielding       = own.undriven;
			own.solutionExists = std::all_of(points.begin(), points.end(),
			        [](const ContactPoint& c) { return c.bias >= 0; });
		}
		if (mayYield && !own.mayYield() && hasYielded(island.problem) && !island.report.converged) {
			island.problem.yielded.assign(island.problem.yielded.size(), false);
			island.sweepAgain();
		}
		island.setSolved();
	}

	/// Sweeps from zero, since squares of the impulses overflow.
	void startAgain(Island& island)
	{
		if (!island.takesExactSteps() || !std::isnan(island.report.residual)
		        || island.remaining().maxIterations == 0)
			return;
		island.problem.clearImpulses();
		island.sweepAgain();
		island.setSolved();
	}

	/// Exact steps would take long without a solution. Few sweeps of slim islands are too far from
	/// the solution for a probe.
	void testBeforeExactSteps(Island& island)
	{
		if (!island.takesExactSteps()) return;
		const bool yieldsAgain = island.settings.mayYield() && hasYielded(island.problem);
		if (yieldsAgain
		        || (island.remaining().maxIterations > 0
		                && mustYield(island.report, island.problem, island.settings,
		                        island.workspace, island.before, !island.report.shape.slim())))
			island.state = State::infeasible;
	}

	void takeExactSteps(Island& island)
	{
		if (!island.takesExactSteps()) return;
		auto& [problem, solver, settings, workspace, report, before, state] = island;
		const Settings left = island.remaining();
		const int      done = report.iterations;
		if (solver == "auto" && !isTight(problem, settings))
			report = continueAuto(problem, settings, report, workspace);
		else
			report = solveExact(problem, left, report, workspace);
		if (report.iterations > done) before.clear();
		island.setSolved();
	}

	void testForYield(Island& island)
	{
		if (mustYield(island.report, island.problem, island.settings, island.workspace,
		            island.before))
			island.state = State::infeasible;
	}

	void yield(Island& island)
	{
		ContactProblem& problem = island.problem;
		for (std::size_t body = 0; body < problem.yielded.size(); ++body)
			problem.yielded[body] = !problem.prescribed(int(body));
		island.report = solveYielding(problem, island.settings, island.workspace)
		                        .plusCostOf(island.report);
		island.state = State::ended;
	}

	/// testForYield covers islands whose contacts may yield.
	void confirm(Island& island)
	{
		if (!island.settings.mayYield() && !island.settings.solutionExists
		        && isFalseSolution(island.problem, island.settings)) {
			island.report.converged = false;
			island.state            = State::unsolved;
			return;
		}
		std::fill(island.problem.yielded.begin(), island.problem.yielded.end(), false);
		island.state = State::ended;
	}

	/// Replaces impulses that would add energy. Without friction, every sweep lowers the cost.
	void sweepFromZero(Island& island)
	{
		ContactProblem&           problem = island.problem;
		std::vector<std::int32_t> points(problem.points.size());
		std::iota(points.begin(), points.end(), 0);
		if (hasPositiveCost(problem, points.begin(), points.end())) {
			Settings sweeps      = island.settings;
			sweeps.maxIterations = std::max(sweeps.minIterations, sweepsFromZero);
			problem.clearImpulses();
			island.report = solveNlgs(problem, sweeps, island.workspace).plusCostOf(island.report);
		}
		island.state = State::ended;
	}

	/// Each stage runs if the island is in its state, in this order.
	struct Stage {
		State state;
		void (*run)(Island&);
	};
	constexpr Stage stages[] = {
		{ State::swept, useOwnDrive },               // → solved, unsolved
		{ State::unsolved, startAgain },             // → solved, unsolved
		{ State::unsolved, testBeforeExactSteps },   // → unsolved, infeasible
		{ State::unsolved, takeExactSteps },         // → solved, unsolved
		{ State::solved, testForYield },             // → solved, infeasible
		{ State::unsolved, testForYield },           // → unsolved, infeasible
		{ State::infeasible, yield },                // → ended
		{ State::solved, confirm },                  // → ended, unsolved
		{ State::unsolved, sweepFromZero },          // → ended
	};

} // namespace

Report complete(ContactProblem& problem, const std::string& solver, const Settings& settings,
        const Report& swept, Workspace& workspace, std::vector<LocalVector> before)
{
	Island island { problem, solver, settings, workspace, swept, std::move(before) };
	for (const Stage& stage : stages)
		if (island.state == stage.state) stage.run(island);
	return island.report;
}

} // namespace rcr

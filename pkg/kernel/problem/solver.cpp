#include "problem/solver.hpp"

#include "problem/infeasibility.hpp"
#include "problem/island_problem.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"
#include "sweep/packed_problem.hpp"

namespace rcr {

constexpr double exactBelow = 1e-6; // residual below which exact steps are faster [-]
constexpr int    leastPatience = 300; // least sweeps without a new lowest residual to exact steps
constexpr int    exactIterations = 10; // exact iterations that cost as much as this patience
constexpr int    smallProblem = 1000; // points; exact steps cost at most some hundred sweeps
constexpr int    sweepsPerExact = 20; // cost of an exact iteration of a small problem [sweeps]
// least maxIterations for a test of divergence; shorter passes run ten sweeps, too few for it
constexpr int    minIterationsToProbe = 20;
constexpr int    sweepsFromZero = 100; // for impulses of positive cost; a few remove most of it
// factor of velocityFloor for small problems: velocity errors at rest make tall stacks drift
constexpr double smallProblemFloorFactor = 1e-3;
constexpr int    maxFineWork = 15000; // most exact iterations × points for this finer floor

static bool frictionless(const ContactProblem& problem)
{
	const auto isFrictionless = [](const ContactPoint& c) { return c.friction == 0; };
	return std::all_of(problem.points.begin(), problem.points.end(), isFrictionless);
}

/// Sweeps without a new lowest residual after which exact steps pay off. Measured: an exact
/// iteration costs 20 sweeps at 1000 points and 220 at 25 000.
static int patience(std::size_t points)
{
	const double size = std::pow(double(points) / smallProblem, 0.75);
	return std::max(leastPatience, int(exactIterations * sweepsPerExact * size));
}

/// Returns true if a prescribed motion closes a contact and also blocks its normal direction.
/// No impulse can open such a contact.
static bool closesBlocked(
        const ContactProblem& problem, const ContactPoint& c, double roundingVelocity)
{
	const auto translates = [&](int body) {
		return problem.inverseMass[body].x > 0 && problem.inverseMass[body].y > 0;
	};
	return !translates(c.body1) && !translates(c.body2) && delassus(problem, c).nn <= 0
	        && !(problem.prescribed(c.body1) && problem.prescribed(c.body2))
	        && relativeVelocity(problem, c).n + c.bias < -roundingVelocity;
}

static bool closesBlockedContact(const ContactProblem& problem, double roundingVelocity)
{
	const auto closes = [&](const ContactPoint& c) {
		return closesBlocked(problem, c, roundingVelocity);
	};
	return std::any_of(problem.points.begin(), problem.points.end(), closes);
}

static bool exceedsYieldImpulse(const ContactProblem& problem, const Settings& settings)
{
	const auto exceeds = [&](const Impulse& p) { return p.n > settings.yielding.yieldImpulse; };
	return std::any_of(problem.impulse.begin(), problem.impulse.end(), exceeds);
}

/// Returns true if contacts have yielded in an earlier pass of the step.
static bool hasYielded(const ContactProblem& problem)
{
	return std::find(problem.yielded.begin(), problem.yielded.end(), true) != problem.yielded.end();
}

/// Runs probeSweeps sweeps on a copy of the problem that the workspace holds. Returns true if the
/// impulses diverge.
static bool probeDivergence(
        const ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	Settings sweeps      = settings;
	sweeps.sameProblem   = true;
	sweeps.tolerance     = 0;
	sweeps.minIterations = sweeps.maxIterations = probeSweeps;
	ContactProblem probe                        = problem;
	solveNesterov(probe, sweeps, workspace);
	return isDivergent(probe, problem.impulse);
}

/// Returns true if contacts must yield. Also tests converged solutions: a wedge can have
/// impulses so large that both relative errors are small.
static bool mustYield(const Report& report, const ContactProblem& problem, const Settings& settings,
        Workspace& workspace)
{
	if (settings.yielding.compliance == 0) return false;
	if (report.yielded || exceedsYieldImpulse(problem, settings)
	        || closesBlockedContact(problem, settings.roundingVelocity)
	        || (mayExceedEnergyBound(report.dissipated, report.mass, report.freeSpeed)
	                && exceedsEnergyBound(problem)))
		return true;
	if (report.converged || settings.tolerance == 0) return false;
	if (hasYielded(problem)) return true;
	if (report.impulseGrowth <= divergentGrowth) return false;
	return settings.maxIterations >= minIterationsToProbe
	        && probeDivergence(problem, settings, workspace);
}

static bool isSmall(const ContactProblem& problem)
{
	return int(problem.points.size()) <= smallProblem;
}

/// Returns true if `auto` runs exact steps as `exact` does.
static bool isFine(const ContactProblem& problem, const Settings& settings)
{
	return settings.tolerance > 0 && settings.tolerance < exactBelow && !frictionless(problem);
}

/// Sweeps of all islands together, the first stage of every solver.
static Report sweepTogether(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Workspace& workspace)
{
	Settings sweeps = settings;
	if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
	if (solver == "sor") return solveSor(problem, settings, workspace);
	if (solver == "nesterov" || problem.stretches()) // exact steps do not support the cell
		return solveNesterov(problem, settings, workspace);
	if (solver == "exact" || isFine(problem, settings))
		return sweepForExactSteps(problem, settings, workspace);
	sweeps.stallSweeps = patience(problem.points.size());
	if (settings.tolerance == 0 || !isSmall(problem))
		return solveNesterov(problem, sweeps, workspace);
	sweeps.velocityFloor *= smallProblemFloorFactor;
	sweeps.maxIterations = std::min(leastPatience, settings.maxIterations);
	Report report        = solveNesterov(problem, sweeps, workspace);
	if (report.kinematicError > 0)
		report.kinematicError = errorsOf(problem, settings.velocityFloor).kinematicError;
	return report;
}

/// `auto` after its sweeps, which have not converged.
static Report continueAuto(ContactProblem& problem, const Settings& settings, const Report& swept,
        Workspace& workspace)
{
	const bool   small = isSmall(problem);
	const double floor = settings.velocityFloor,
	             fine  = small ? floor * smallProblemFloorFactor : floor;
	Report       report    = swept;
	const auto   left      = [&] { return settings.maxIterations - report.iterations; };
	const auto   converged = [&] {
        return report.meetsResidual(settings)
                && errorsOf(problem, floor).kinematicError <= settings.kinematicTolerance;
	};
	const auto runExact = [&](int iterations, double velocityFloor, int cost) {
		Settings steps      = settings;
		steps.sameProblem   = true;
		steps.velocityFloor = velocityFloor;
		steps.maxIterations = iterations;
		steps.exactCost     = cost;
		report              = solveExact(problem, steps, report, workspace);
	};
	const int  cost           = small ? sweepsPerExact : 1;
	const bool residualMet    = small && report.meetsResidual(settings);
	int        fineIterations = left();
	if (residualMet) { // limits the work of exact steps, which improve the velocities only
		fineIterations = std::min(left(), maxFineWork / int(problem.points.size()));
		if (left() > fineIterations && !converged()) {
			Settings sweeps      = settings;
			sweeps.sameProblem   = true;
			sweeps.stallSweeps   = patience(problem.points.size());
			sweeps.maxIterations = left() - fineIterations;
			report               = solveNesterov(problem, sweeps, workspace).after(report);
		}
	}
	if (fineIterations > 0) runExact(fineIterations, fine, residualMet ? 1 : cost);
	if (small && !report.yielded && left() > 0 && !converged()) runExact(left(), floor, cost);
	report.kinematicError = errorsOf(problem, floor).kinematicError;
	report.converged      = report.converged || report.meetsTolerances(settings);
	return report;
}

/// The exact steps of `exact` and `auto`, if sweeps have not converged.
static Report solveRigid(ContactProblem& problem, const std::string& solver,
        const Settings& settings, const Report& swept, Workspace& workspace)
{
	const bool exact = solver == "exact" || (solver == "auto" && settings.tolerance > 0);
	if (swept.converged || !exact || problem.stretches()) return swept;
	Settings steps = settings;
	steps.maxIterations -= swept.iterations;
	const bool yieldsAgain = settings.yielding.compliance > 0 && hasYielded(problem);
	if (yieldsAgain
	        || (steps.maxIterations > 0 && mustYield(swept, problem, settings, workspace))) {
		Report report  = swept; // exact steps would take long and find no solution
		report.yielded = true;
		return report;
	}
	if (solver == "exact" || isFine(problem, settings))
		return steps.maxIterations > 0 ? solveExact(problem, steps, swept, workspace) : swept;
	return continueAuto(problem, settings, swept, workspace);
}

/// Sweeps from zero impulses. Without friction, every sweep lowers the cost.
static Report solveFromZero(ContactProblem& problem, const Settings& settings, Workspace& workspace)
{
	Settings sweeps      = settings;
	sweeps.sameProblem   = true;
	sweeps.maxIterations = std::max(settings.minIterations, sweepsFromZero);
	problem.impulse.assign(problem.points.size(), {});
	return solveNlgs(problem, sweeps, workspace);
}

const std::vector<std::string>& solverNames()
{
	static const std::vector<std::string> names { "nlgs", "sor", "nesterov", "exact", "auto" };
	return names;
}

void checkSettings(const std::string& solver, const Settings& s)
{
	requireKnown("solver", solver, solverNames());
	if (!(s.tolerance >= 0 && std::isfinite(s.tolerance)))
		refuse("tolerance = ", s.tolerance, ": give a finite residual ≥ 0; 0 runs all iterations");
	if (s.maxIterations < 1) refuse("maxIterations = ", s.maxIterations, ": give at least 1");
	if (s.checkInterval < 1) refuse("checkInterval = ", s.checkInterval, ": give at least 1 sweep");
	if (s.minIterations < 0 || s.minIterations > s.maxIterations)
		refuse("minIterations = ", s.minIterations,
		       ": give at least 0, and at most maxIterations = ", s.maxIterations);
	if (s.stallSweeps < 0)
		refuse("stallSweeps = ", s.stallSweeps, ": give at least 1, or 0 to ignore stalls");
	if (s.threads < 1) refuse("threads = ", s.threads, ": give at least 1");
	if (s.lanes != 0 && s.lanes != 1 && s.lanes != 4 && s.lanes != 8)
		refuse("lanes = ", s.lanes, ": give 1, 4, 8, or 0 for the width of the processor");
	if (!(s.kinematicTolerance >= 0))
		refuse("kinematicTolerance = ", s.kinematicTolerance,
		       ": give a fraction ≥ 0; infinity disables the test");
	if (!(s.yielding.compliance >= 0))
		refuse("yieldCompliance = ", s.yielding.compliance,
		       ": give a fraction ≥ 0 of the response of a contact; 0 keeps contacts rigid");
	if (!(s.yielding.yieldImpulse > 0))
		refuse("yieldImpulse = ", s.yielding.yieldImpulse,
		       ": give an impulse > 0; infinity sets no bound");
	if (!(s.meanForceChange >= 0 && std::isfinite(s.meanForceChange)))
		refuse("meanForceChange = ", s.meanForceChange,
		       ": give a finite change ≥ 0; 0 disables the criterion");
}

/// Completes the solution of an island, or of a problem with one island, after its sweeps.
static Report complete(ContactProblem& problem, const std::string& solver, const Settings& settings,
        const Report& swept, Workspace& workspace)
{
	Report rigid = solveRigid(problem, solver, settings, swept, workspace);
	if (mustYield(rigid, problem, settings, workspace)) {
		for (std::size_t body = 0; body < problem.yielded.size(); ++body)
			problem.yielded[body] = !problem.prescribed(int(body));
		return solveYielding(problem, settings, workspace).after(rigid);
	}
	// mustYield has tested contacts that may yield
	const bool mayHaveNoSolution = settings.yielding.compliance == 0 && rigid.converged;
	if (mayHaveNoSolution // the residual omits a blocked contact, and impulses that grow lower it
	    && (exceedsEnergyBound(problem)
	            || (closesBlockedContact(problem, settings.roundingVelocity)
	                    && closesBlockedContact(problem, 1e-12 * drivenSpeed(problem)))))
		rigid.converged = false;
	if (rigid.converged || !hasPositiveCost(problem)) return rigid;
	return solveFromZero(problem, settings, workspace).after(rigid);
}

/// Completes the islands that have not converged, or that may have no solution.
static Report completeIslands(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Report report, Workspace& workspace)
{
	std::vector<std::int32_t> begin, points;
	workspace.packed().listPoints(begin, points);
	const auto mayYield = [&](std::int32_t k) {
		return problem.impulse[k].n > settings.yielding.yieldImpulse
		        || closesBlocked(problem, problem.points[k], settings.roundingVelocity);
	};
	std::vector<Report> islands = std::move(report.islands);
	bool                changed = false;
	for (std::size_t number = 0; number < islands.size(); ++number) {
		Report&    island = islands[number];
		const auto first = points.begin() + begin[number], last = points.begin() + begin[number + 1];
		if (island.converged
		        && !mayExceedEnergyBound(island.dissipated, island.mass, island.freeSpeed)
		        && std::none_of(first, last, mayYield))
			continue;
		IslandProblem part(problem, { first, last });
		Workspace     own;
		const int     swept = island.iterations;
		island              = complete(part.problem, solver, settings, island, own);
		if (island.iterations == swept) continue; // the impulses have not changed
		part.store(problem);
		changed = true;
	}
	if (changed) {
		const Errors errors   = errorsOf(problem, settings.velocityFloor);
		report.residual       = errors.residual;
		report.kinematicError = errors.kinematicError;
	}
	report.combine(std::move(islands));
	return report;
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings,
        Workspace& workspace)
{
	if (!settings.sameProblem) checkProblem(problem, workspace.team()); // bad input before settings
	checkSettings(solver, settings);
	Report swept = sweepTogether(problem, solver, settings, workspace);
	if (swept.islands.size() <= 1) return complete(problem, solver, settings, swept, workspace);
	return completeIslands(problem, solver, settings, std::move(swept), workspace);
}

} // namespace rcr

#include "problem/solver.hpp"

#include "problem/infeasibility.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"

namespace rcr {

constexpr double exactBelow = 1e-6; // residual below which exact steps are faster [-]
constexpr int    leastPatience = 300; // least sweeps without a new lowest residual to exact steps
constexpr int    exactIterations = 10; // exact iterations that cost as much as this patience
constexpr int    sweepsAfterYield = 50; // sweeps of a later pass of a step that has yielded
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

static bool exceedsYieldImpulse(const ContactProblem& problem, const Settings& settings)
{
	const auto exceeds = [&](const Impulse& p) { return p.n > settings.yielding.yieldImpulse; };
	return std::any_of(problem.impulse.begin(), problem.impulse.end(), exceeds);
}

/// Returns true if a prescribed motion closes a contact and also blocks its normal direction.
/// No impulse can open such a contact.
static bool closesBlockedContact(const ContactProblem& problem, double roundingVelocity)
{
	const auto translates = [&](int body) {
		return problem.inverseMass[body].x > 0 && problem.inverseMass[body].y > 0;
	};
	return std::any_of(
	        problem.points.begin(), problem.points.end(), [&](const ContactPoint& c) {
		        return !translates(c.body1) && !translates(c.body2)
		                && delassus(problem, c).nn <= 0
		                && !(problem.prescribed(c.body1) && problem.prescribed(c.body2))
		                && relativeVelocity(problem, c).n + c.bias < -roundingVelocity;
	        });
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
	        || (mayExceedEnergyBound(problem, report.dissipated, report.freeSpeed)
	                && exceedsEnergyBound(problem)))
		return true;
	if (report.converged || settings.tolerance == 0) return false;
	if (settings.yieldedBefore) return true;
	if (report.impulseGrowth <= divergentGrowth) return false;
	return settings.maxIterations >= minIterationsToProbe
	        && probeDivergence(problem, settings, workspace);
}

static Report solveAuto(ContactProblem& problem, Settings settings, Workspace& workspace)
{
	const bool   small = settings.tolerance > 0 && int(problem.points.size()) <= smallProblem;
	const double floor = settings.velocityFloor;
	const int    most  = settings.maxIterations;
	if (small) settings.velocityFloor *= smallProblemFloorFactor;
	if (settings.tolerance > 0 && settings.tolerance < exactBelow && !frictionless(problem))
		return solveExact(problem, settings, workspace);
	Settings sweeps    = settings;
	sweeps.stallSweeps = patience(problem.points.size());
	if (small) sweeps.maxIterations = std::min(leastPatience, most);
	Report report = solveNesterov(problem, sweeps, workspace);
	if (report.converged || settings.tolerance == 0) return report;
	const auto left      = [&] { return most - report.iterations; };
	const auto converged = [&] {
		return report.meetsResidual(settings)
		        && errorsOf(problem, floor).kinematicError <= settings.kinematicTolerance;
	};
	const auto runExact = [&](int iterations, double velocityFloor, int cost) {
		Settings steps      = settings;
		steps.sameProblem   = true;
		steps.velocityFloor = velocityFloor;
		steps.maxIterations = iterations;
		steps.exactCost     = cost;
		report              = solveExact(problem, steps, workspace, &report).after(report);
	};
	if (left() > 0) {
		report.yielded = mustYield(report, problem, settings, workspace);
		if (report.yielded) return report; // exact steps would take long and find no solution
	}
	const int  cost           = small ? sweepsPerExact : 1;
	const bool residualMet    = small && report.meetsResidual(settings);
	int        fineIterations = left();
	if (residualMet) { // limits the work of exact steps, which improve the velocities only
		fineIterations = std::min(left(), maxFineWork / int(problem.points.size()));
		if (left() > fineIterations && !converged()) {
			sweeps.sameProblem   = true;
			sweeps.velocityFloor = floor;
			sweeps.maxIterations = left() - fineIterations;
			report               = solveNesterov(problem, sweeps, workspace).after(report);
		}
	}
	if (fineIterations > 0)
		runExact(fineIterations, settings.velocityFloor, residualMet ? 1 : cost);
	if (small && !report.yielded && left() > 0 && !converged()) runExact(left(), floor, cost);
	if (small) report.kinematicError = errorsOf(problem, floor).kinematicError;
	report.converged = report.converged || report.meetsTolerances(settings);
	return report;
}

/// Solves with rigid contacts. The report has `yielded` if it found that no rigid solution
/// exists.
static Report solveRigid(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Workspace& workspace)
{
	if (settings.yieldedBefore && settings.yielding.compliance > 0) {
		Settings few      = settings;
		few.maxIterations = std::min(settings.maxIterations, sweepsAfterYield);
		return solveNesterov(problem, few, workspace);
	}
	if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
	if (solver == "sor") return solveSor(problem, settings, workspace);
	if (solver == "nesterov" || problem.stretches()) // exact steps do not support the cell
		return solveNesterov(problem, settings, workspace);
	if (solver == "exact") return solveExact(problem, settings, workspace);
	return solveAuto(problem, settings, workspace);
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

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings,
        Workspace& workspace)
{
	if (!settings.sameProblem) checkProblem(problem, workspace.team()); // bad input before settings
	checkSettings(solver, settings);
	Report rigid = solveRigid(problem, solver, settings, workspace);
	if (mustYield(rigid, problem, settings, workspace))
		return solveYielding(problem, settings, rigid, workspace).after(rigid);
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

} // namespace rcr

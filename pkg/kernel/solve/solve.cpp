#include "solve/solve.hpp"

#include <numeric>

#include "problem/infeasibility.hpp"
#include "problem/island_problem.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"
#include "solve/solve_auto.hpp"
#include "sweep/packed_problem.hpp"

namespace rcr {

constexpr double exactBelow = 1e-6; // residual below which exact steps are faster [-]
// a test of divergence needs 20 iterations; later passes may be limited to ten
constexpr int    minIterationsToProbe = 20;
constexpr int    sweepsFromZero = 100; // they replace impulses that would add energy
// a rigid contact may exceed yieldImpulse by this many impulses |b_n|/w_nn of its rebound
constexpr double mostRebounds = 3;

static bool frictionless(const ContactProblem& problem)
{
	const auto isFrictionless = [](const ContactPoint& c) { return c.friction == 0; };
	return std::all_of(problem.points.begin(), problem.points.end(), isFrictionless);
}

/// Returns true if a point must yield, whether its island has converged or not.
static bool mustYieldAt(const ContactProblem& problem, std::size_t k, const Settings& settings)
{
	const ContactPoint& c      = problem.points[k];
	const double        excess = problem.impulse[k].n - settings.yielding.yieldImpulse;
	return (excess > 0 && excess * delassus(problem, c).nn > mostRebounds * std::max(0.0, -c.bias))
	        || closesBlocked(problem, c, settings.roundingVelocity);
}

/// Returns true if a blocked contact closes by more than rounding errors of the largest |u_free|.
static bool anyClosesBlocked(const ContactProblem& problem, const Settings& settings)
{
	double largest2 = 0;
	for (const ContactPoint& c : problem.points)
		largest2 = std::max(largest2, square(freeRelativeVelocity(problem, c)));
	const double rounding = std::max(settings.roundingVelocity, roundingShare * std::sqrt(largest2));
	return std::any_of(problem.points.begin(), problem.points.end(),
	        [&](const ContactPoint& c) { return closesBlocked(problem, c, rounding); });
}

using PointIterator = std::vector<std::int32_t>::const_iterator;

/// Returns true if the impulses of these points, those of an island, would add energy to the step:
/// the cost ½ pᵀWp + p · (u_free + b_n n) [J/m] is positive. Frictionless solutions minimise it; zero
/// impulses cost 0. Solvers that start far from the solution can end with such impulses.
static bool hasPositiveCost(const ContactProblem& problem, PointIterator first, PointIterator last)
{
	const double cost = std::accumulate(first, last, 0.0, [&](double sum, std::int32_t k) {
		const ContactPoint& c = problem.points[k];
		const LocalVector & p = problem.impulse[k], u = relativeVelocity(problem, c);
		return sum + (0.5 * (dot(p, u) + dot(p, freeRelativeVelocity(problem, c))) + p.n * c.bias);
	});
	return !(cost <= 0); // true also if products of large impulses overflow to NaN
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

/// Also true if the growth is NaN or was not measured.
static bool mayDiverge(const Report& report, const Settings& settings)
{
	return !(report.impulseGrowth <= divergentGrowth)
	        && settings.maxIterations >= minIterationsToProbe;
}

/// Heuristic filter before exceedsEnergyBound. It uses the mass of all bodies of an island and the
/// RMS |u_free| of its points. So it may overlook a wedge in a large island.
static bool mayExceedEnergyBound(const Report& report)
{
	return exceedsEnergyBound(report.dissipated, std::sqrt(report.mass) * report.freeSpeed);
}

/// Returns true if contacts must yield. Also tests converged solutions: a wedge can have
/// impulses so large that both relative errors are small. `probes`: also looks for impulses that
/// diverge.
static bool mustYield(const Report& report, const ContactProblem& problem, const Settings& settings,
        Workspace& workspace, bool probes = true)
{
	if (!settings.mayYield()) return false;
	if (report.yielded || (mayExceedEnergyBound(report) && exceedsEnergyBound(problem)))
		return true;
	for (std::size_t k = 0; k < problem.points.size(); ++k)
		if (mustYieldAt(problem, k, settings)) return true;
	if (report.converged || settings.tolerance == 0) return false;
	if (hasYielded(problem)) return true;
	return probes && mayDiverge(report, settings)
	        && probeDivergence(problem, settings, workspace);
}

static bool rolls(const ContactProblem& problem)
{
	return std::any_of(problem.points.begin(), problem.points.end(),
	        [](const ContactPoint& c) { return c.rolls(); });
}

/// Returns true if `auto` runs exact steps as `exact` does.
static bool isTight(const ContactProblem& problem, const Settings& settings)
{
	return settings.tolerance > 0 && settings.tolerance < exactBelow && !frictionless(problem)
	        && !rolls(problem);
}

/// Sweeps of all islands together, the first stage of every solver.
static Report sweepTogether(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Workspace& workspace)
{
	if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
	if (solver == "sor") return solveNlgs(problem, settings, workspace, sorRelaxation);
	if (solver == "nesterov")
		return solveNesterov(problem, settings, workspace);
	if (solver == "exact" || isTight(problem, settings))
		return sweepForExactSteps(problem, settings, workspace);
	Settings sweeps = settings;
	sweeps.ofIsland = firstSweepsOfAuto;
	return solveNesterov(problem, sweeps, workspace);
}

static bool takesExactSteps(
        const std::string& solver, const Settings& settings, const IslandShape& shape)
{
	if (shape.rolls) return false;
	return solver == "exact" || (solver == "auto" && settings.tolerance > 0);
}

/// These settings with the iterations that are left after the sweeps.
static Settings remaining(const Settings& settings, const Report& swept)
{
	Settings left      = settings;
	left.maxIterations = std::max(settings.maxIterations - swept.iterations, 0);
	return left;
}

/// The exact steps of `exact` and `auto`, if sweeps have not converged.
static Report solveRigid(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Report swept, Workspace& workspace)
{
	if (swept.converged || !takesExactSteps(solver, settings, swept.shape)) return swept;
	if (std::isnan(swept.residual) && swept.iterations < settings.maxIterations) {
		problem.impulse.assign(problem.points.size(), {}); // their squares overflow
		swept = sweepTogether(problem, solver, remaining(settings, swept), workspace)
		                .plusCostOf(swept);
		if (swept.converged) return swept;
	}
	const Settings steps       = remaining(settings, swept);
	const bool     yieldsAgain = settings.mayYield() && hasYielded(problem);
	const bool probes = !swept.shape.slim(); // few sweeps of slim islands are far from the solution
	if (yieldsAgain
	        || (steps.maxIterations > 0
	                && mustYield(swept, problem, settings, workspace, probes))) {
		Report report  = swept; // exact steps would take long and find no solution
		report.yielded = true;
		return report;
	}
	if (solver == "exact" || isTight(problem, settings))
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

static Settings settingsOf(const ContactProblem& island, Settings settings)
{
	if (!settings.mayYield() || island.stretches() || isDriven(island)) return settings;
	settings.yielding       = settings.undriven;
	settings.solutionExists = std::all_of(island.points.begin(), island.points.end(),
	        [](const ContactPoint& c) { return c.bias >= 0; });
	return settings;
}

/// Completes the solution of an island, or of a problem with one island, after its sweeps.
static Report complete(ContactProblem& problem, const std::string& solver, const Settings& given,
        Report swept, Workspace& workspace)
{
	const Settings settings = settingsOf(problem, given);
	if (given.mayYield() && !settings.mayYield() && hasYielded(problem) && !swept.converged) {
		problem.yielded.assign(problem.yielded.size(), false); // it has had few sweeps
		swept = sweepTogether(problem, solver, remaining(settings, swept), workspace)
		                .plusCostOf(swept);
	}
	Report rigid = solveRigid(problem, solver, settings, swept, workspace);
	if (mustYield(rigid, problem, settings, workspace)) {
		for (std::size_t body = 0; body < problem.yielded.size(); ++body)
			problem.yielded[body] = !problem.prescribed(int(body));
		return solveYielding(problem, settings, workspace).plusCostOf(rigid);
	}
	// mustYield covers problems whose contacts may yield
	if (rigid.converged && !settings.mayYield() && !settings.solutionExists
	        // the residual omits blocked contacts, and growing impulses lower it
	        && (exceedsChangeBound(problem) || anyClosesBlocked(problem, settings)))
		rigid.converged = false;
	if (rigid.converged) {
		std::fill(problem.yielded.begin(), problem.yielded.end(), false);
		return rigid;
	}
	std::vector<std::int32_t> points(problem.points.size());
	std::iota(points.begin(), points.end(), 0);
	if (!hasPositiveCost(problem, points.begin(), points.end())) return rigid;
	return solveFromZero(problem, settings, workspace).plusCostOf(rigid);
}

/// Completes the islands that have not converged, or that may have no solution.
static Report completeIslands(ContactProblem& problem, const std::string& solver,
        const Settings& settings, Report report, Workspace& workspace)
{
	std::vector<std::int32_t> begin, points;
	workspace.packed().listPoints(begin, points);
	const auto perhapsMustYield = [&](std::int32_t k) {
		const ContactPoint& c = problem.points[k];
		return problem.hasYielded(c.body1) || problem.hasYielded(c.body2)
		        || mustYieldAt(problem, k, settings);
	};
	const auto needsMore = [&](const Report& island, PointIterator first, PointIterator last) {
		if (!settings.solutionExists
		        && (settings.yielding.compliance == 0
		                || mayExceedEnergyBound(island)
		                || std::any_of(first, last, perhapsMustYield)))
			return true;
		if (island.converged) return false;
		const bool isSmall = last - first <= smallProblem || island.shape.slim(); // few sweeps
		return (takesExactSteps(solver, settings, island.shape)
		               && (isSmall || island.iterations < settings.maxIterations))
		        || (settings.mayYield() && mayDiverge(island, settings))
		        || hasPositiveCost(problem, first, last);
	};
	std::vector<Report> islands = std::move(report.islands);
	bool                changed = false;
	for (std::size_t number = 0; number < islands.size(); ++number) {
		Report&             island = islands[number];
		const PointIterator first  = points.begin() + begin[number],
		                    last   = points.begin() + begin[number + 1];
		if (!needsMore(island, first, last)) continue;
		IslandProblem part(problem, { first, last });
		Workspace     own;
		island = complete(part.problem, solver, settings, island, own);
		part.store(problem);
		changed = true;
	}
	if (changed) {
		// islands without errors report 0, not rounding errors
		const bool solved = std::all_of(islands.begin(), islands.end(),
		        [](const Report& island) { return island.residual == 0; });
		report.residual = solved ? 0 : residualOf(problem);
		report.impulseGrowth = std::numeric_limits<double>::infinity(); // not measured
	}
	report.combine(std::move(islands));
	return report;
}

namespace {

	/// While it lives, impulses of the problem contain the pulls, p + c n, and free velocities are
	/// those after the pulls. So the contact laws hold without them.
	class PullSubstitution {
	public:
		explicit PullSubstitution(ContactProblem& problem)
		        : problem_(problem)
		{
			const auto pulls = [](const ContactPoint& c) { return c.pull > 0; };
			if (std::none_of(problem.points.begin(), problem.points.end(), pulls)) return;
			freeVelocity_ = problem.freeVelocity;
			std::vector<LocalVector> pull;
			for (const ContactPoint& c : problem.points)
				pull.push_back({ -c.pull, 0 });
			stretchRate_ = addImpulses(problem, pull, problem.freeVelocity);
			problem.stretchRate = problem.stretchRate - stretchRate_;
			shift(+1);
		}
		PullSubstitution(const PullSubstitution&) = delete;
		~PullSubstitution()
		{
			if (freeVelocity_.empty()) return;
			problem_.freeVelocity = std::move(freeVelocity_);
			problem_.stretchRate  = problem_.stretchRate + stretchRate_;
			shift(-1);
		}

	private:
		void shift(double sign)
		{
			for (std::size_t k = 0; k < problem_.points.size(); ++k)
				problem_.impulse[k].n += sign * problem_.points[k].pull;
		}

		ContactProblem&           problem_;
		std::vector<PlanarVector> freeVelocity_; // given; empty: no pull
		Vec2                      stretchRate_;
	};

} // namespace

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings,
        Workspace& workspace)
{
	if (!settings.sameProblem) checkProblem(problem, workspace.team()); // bad input before settings
	checkSettings(solver, settings);
	if (solver == "exact" && rolls(problem))
		refuse("solver='exact' knows no rolling friction; use 'auto', 'nesterov', 'nlgs' or 'sor'");
	const PullSubstitution pulled(problem);
	Report swept = sweepTogether(problem, solver, settings, workspace);
	if (swept.islands.size() <= 1) return complete(problem, solver, settings, swept, workspace);
	return completeIslands(problem, solver, settings, std::move(swept), workspace);
}

} // namespace rcr

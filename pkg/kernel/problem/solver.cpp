#include "problem/solver.hpp"

#include "problem/infeasibility.hpp"
#include "problem/residual.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace rcr {

namespace {

	constexpr double finestForSweeps = 1e-6; // residual below which the exact tier is the faster way, if there is friction
	constexpr int    hopeless        = 300; // sweeps without a new low of the residual, or as many as these exact iterations take
	constexpr int    hopelessExact   = 10;
	constexpr int    someSweeps      = 50;   // of a further pass on a step that has no solution
	constexpr int    fewPoints       = 1000; // whose exact steps cost no more than some hundred sweeps …
	constexpr int    exactSweeps     = 20; // … and an iteration of them about as much as so many; one of more points more
	constexpr int    fewestToProbe   = 20; // iterations: a further pass of ten sweeps tells nothing
	constexpr int    sweepsAnew      = 100; // of a step whose impulses are worse than none: a few take most of what there is to take
	constexpr double finerRest       = 1e-3; // of Settings::rest for these: what is left at rest is noise, and a tall stack wanders with it …
	constexpr int    finerPoints     = 15000; // … but no more exact iterations times points are paid for it than this

	template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
	{
		std::ostringstream text;
		(text << ... << parts);
		throw std::invalid_argument(text.str());
	}

	bool frictionless(const ContactProblem& problem)
	{
		return std::all_of(problem.points.begin(), problem.points.end(), [](const ContactPoint& c) { return c.friction == 0; });
	}

	/// Sweeps after whose failure exact steps are worth their time: measured, an iteration of these takes 20 sweeps of 1000 points and 220 of 25 000.
	int patience(std::size_t points)
	{
		return std::max(hopeless, int(hopelessExact * exactSweeps * std::pow(double(points) / fewPoints, 0.75)));
	}

	bool bearsTooMuch(const ContactProblem& problem, const Settings& settings)
	{
		return std::any_of(problem.impulse.begin(), problem.impulse.end(), [&](const Impulse& p) { return p.n > settings.mostImpulse; });
	}

	/// Whether there is no use in going on with rigid contacts. A solution that was found may be none: errors are measured by forces and by
	/// velocities, and both can be those of a wedge.
	bool mustYield(const Report& report, const ContactProblem& problem, const Settings& settings, Workspace& workspace)
	{
		if (settings.compliance == 0) return false;
		if (report.yielded) return true;
		if (bearsTooMuch(problem, settings)) return true;
		if (mayTakeTooMuch(problem, report.taken, report.freeSpeed) && takesTooMuch(problem)) return true;
		if (report.converged || settings.tolerance == 0) return false;
		if (settings.yielded) return true;
		if (report.grown <= leastGrowth) return false; // in the sweeps that were made already
		return settings.maxIterations >= fewestToProbe && growsWithoutBound(problem, settings, workspace);
	}

	/// What a solver has left of what another one has left.
	Report following(const Report& before, Report report)
	{
		report.iterations += before.iterations;
		report.work += before.work;
		return report;
	}

	Report solveAuto(ContactProblem& problem, Settings settings, Workspace& workspace)
	{
		const bool   few  = settings.tolerance > 0 && int(problem.points.size()) <= fewPoints;
		const double rest = settings.rest;
		const int    most = settings.maxIterations;
		if (few) settings.rest *= finerRest;
		if (settings.tolerance > 0 && settings.tolerance < finestForSweeps && !frictionless(problem)) return solveExact(problem, settings, workspace);
		Settings sweeps    = settings;
		sweeps.stallSweeps = patience(problem.points.size());
		if (few) sweeps.maxIterations = std::min(hopeless, most);
		Report report = solveNesterov(problem, sweeps, workspace);
		if (report.converged || settings.tolerance == 0) return report;
		const auto left  = [&] { return most - report.iterations; };
		const auto meets = [&] { return report.reached(settings) && violation(problem, rest) <= settings.violation; };
		const auto exact = [&](int iterations, double toRest, int cost) { // on from what the report tells
			Settings steps      = settings;
			steps.continued     = true;
			steps.rest          = toRest;
			steps.maxIterations = iterations;
			steps.exactCost     = cost;
			const Report before = report;
			report              = following(before, solveExact(problem, steps, workspace, &before));
		};
		if (left() > 0) {
			report.yielded = mustYield(report, problem, settings, workspace);
			if (report.yielded) return report; // exact steps would do no better, and take long
		}
		const int  cost  = few ? exactSweeps : 1;
		const bool known = few && report.reached(settings);
		int        finer = left();
		if (known) { // forces are known, velocities not as finely: exact steps would take long over that
			finer = std::min(left(), finerPoints / int(problem.points.size()));
			if (left() > finer && !meets()) {
				sweeps.continued     = true;
				sweeps.rest          = rest;
				sweeps.maxIterations = left() - finer;
				report               = following(report, solveNesterov(problem, sweeps, workspace));
			}
		}
		if (finer > 0) exact(finer, settings.rest, known ? 1 : cost);
		if (few && !report.yielded && left() > 0 && !meets()) exact(left(), rest, cost);
		if (few) report.violation = violation(problem, rest);
		report.converged = report.converged || (report.reached(settings) && report.violation <= settings.violation);
		return report;
	}

	/// With rigid contacts; `yielded` says that the solver has seen that there is no solution.
	Report solveRigid(ContactProblem& problem, const std::string& solver, const Settings& settings, Workspace& workspace)
	{
		if (settings.yielded) {
			Settings some      = settings;
			some.maxIterations = std::min(settings.maxIterations, someSweeps);
			return solveNesterov(problem, some, workspace);
		}
		if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
		if (solver == "sor") return solveSor(problem, settings, workspace);
		if (solver == "nesterov" || problem.stretches()) return solveNesterov(problem, settings, workspace); // exact steps know no cell
		if (solver == "exact") return solveExact(problem, settings, workspace);
		return solveAuto(problem, settings, workspace);
	}

	/// Sweeps from no impulses at all, each of which leads downhill where there is no friction.
	Report solveAnew(ContactProblem& problem, const Settings& settings, Workspace& workspace)
	{
		Settings sweeps      = settings;
		sweeps.continued     = true;
		sweeps.maxIterations = std::max(settings.minIterations, sweepsAnew);
		problem.impulse.assign(problem.points.size(), {});
		return solveNlgs(problem, sweeps, workspace);
	}

} // namespace

const std::vector<std::string>& solverNames()
{
	static const std::vector<std::string> names { "nlgs", "sor", "nesterov", "exact", "auto" };
	return names;
}

void checkSettings(const std::string& solver, const Settings& s)
{
	const std::vector<std::string>& names = solverNames();
	if (std::find(names.begin(), names.end(), solver) == names.end()) {
		std::string known;
		for (const std::string& name : names)
			known += " " + name;
		refuse("solver '", solver, "' is not known: give one of", known);
	}
	if (!(s.tolerance >= 0 && std::isfinite(s.tolerance))) refuse("tolerance = ", s.tolerance, ": give a finite residual ≥ 0; 0 runs all iterations");
	if (s.maxIterations < 1) refuse("maxIterations = ", s.maxIterations, ": give at least 1");
	if (s.checkInterval < 1) refuse("checkInterval = ", s.checkInterval, ": give at least 1 sweep");
	if (s.minIterations < 0 || s.minIterations > s.maxIterations)
		refuse("minIterations = ", s.minIterations, ": give at least 0, and no more than maxIterations = ", s.maxIterations);
	if (s.stallSweeps < 0) refuse("stallSweeps = ", s.stallSweeps, ": give at least 1, or 0 to go on in any case");
	if (s.threads < 1) refuse("threads = ", s.threads, ": give at least 1");
	if (s.lanes != 0 && s.lanes != 1 && s.lanes != 4 && s.lanes != 8)
		refuse("lanes = ", s.lanes, ": give 1, 4, 8, or 0 for as many as the processor has");
	if (!(s.violation >= 0)) refuse("violation = ", s.violation, ": give a fraction ≥ 0, infinity for no test");
	if (!(s.compliance >= 0)) refuse("compliance = ", s.compliance, ": give a share ≥ 0 of the response of a contact; 0 does not use it");
	if (!(s.mostImpulse > 0)) refuse("mostImpulse = ", s.mostImpulse, ": give an impulse > 0, infinity for no bound");
	if (!(s.meanForceChange >= 0 && std::isfinite(s.meanForceChange)))
		refuse("meanForceChange = ", s.meanForceChange, ": give a finite change ≥ 0; 0 does not use it");
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings)
{
	Workspace workspace;
	return solve(problem, solver, settings, workspace);
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings, Workspace& workspace)
{
	if (!settings.continued) checkProblem(problem, workspace.team()); // first: settings may follow from it
	checkSettings(solver, settings);
	const Report rigid = solveRigid(problem, solver, settings, workspace);
	if (mustYield(rigid, problem, settings, workspace)) return following(rigid, solveYielding(problem, settings, rigid, workspace));
	return rigid.converged || !worseThanNone(problem) ? rigid : following(rigid, solveAnew(problem, settings, workspace));
}

} // namespace rcr

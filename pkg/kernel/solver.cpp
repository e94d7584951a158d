#include "solver.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace rcr {

namespace {

	constexpr double finestForSweeps = 1e-5; // residual below which the exact tier is the faster way

	template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
	{
		std::ostringstream text;
		(text << ... << parts);
		throw std::invalid_argument(text.str());
	}

	void check(const Settings& s)
	{
		if (!(s.tolerance >= 0)) refuse("tolerance = ", s.tolerance, ": give a residual ≥ 0; 0 runs all iterations");
		if (s.maxIterations < 1) refuse("maxIterations = ", s.maxIterations, ": give at least 1");
		if (s.checkInterval < 1) refuse("checkInterval = ", s.checkInterval, ": give at least 1 sweep");
		if (s.minIterations < 0) refuse("minIterations = ", s.minIterations, ": give at least 0");
		if (s.threads < 1) refuse("threads = ", s.threads, ": give at least 1");
		if (s.lanes != 0 && s.lanes != 1 && s.lanes != 4 && s.lanes != 8)
			refuse("lanes = ", s.lanes, ": give 1, 4, 8, or 0 for as many as the processor has");
		if (!(s.violation >= 0)) refuse("violation = ", s.violation, ": give a fraction ≥ 0, infinity for no test");
		if (!(s.meanForceChange >= 0)) refuse("meanForceChange = ", s.meanForceChange, ": give a change ≥ 0; 0 does not use it");
	}

	void check(const ContactProblem& problem)
	{
		const std::size_t bodies = problem.inverseMass.size(), points = problem.points.size();
		if (problem.freeVelocity.size() != bodies)
			refuse("freeVelocity holds ", problem.freeVelocity.size(), " bodies, inverseMass ", bodies, ": give one each a body");
		if (problem.impulse.size() != points)
			refuse("impulse holds ", problem.impulse.size(), " points, points ", points, ": give one each a point, zeros for a cold start");
		for (std::size_t k = 0; k < points; ++k) {
			const ContactPoint& c = problem.points[k];
			for (std::int32_t body : { c.body1, c.body2 })
				if (body < 0 || std::size_t(body) >= bodies)
					refuse("point ", k, " names body ", body, ": give an index from 0 to ", bodies, " − 1");
			if (c.body1 == c.body2) refuse("point ", k, " joins body ", c.body1, " to itself: give two bodies");
			if (!(c.friction >= 0)) refuse("point ", k, " has friction ", c.friction, ": give µ ≥ 0");
		}
	}

} // namespace

const std::vector<std::string>& solverNames()
{
	static const std::vector<std::string> names { "nlgs", "sor", "nesterov", "exact", "auto" };
	return names;
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings)
{
	Workspace workspace;
	return solve(problem, solver, settings, workspace);
}

Report solve(ContactProblem& problem, const std::string& solver, const Settings& settings, Workspace& workspace)
{
	check(settings);
	check(problem);
	if (solver == "nlgs") return solveNlgs(problem, settings, workspace);
	if (solver == "sor") return solveSor(problem, settings, workspace);
	if (solver == "exact" || (solver == "auto" && settings.tolerance > 0 && settings.tolerance < finestForSweeps))
		return solveExact(problem, settings);
	if (solver == "nesterov" || solver == "auto") return solveNesterov(problem, settings, workspace);
	std::string known;
	for (const std::string& name : solverNames())
		known += " " + name;
	refuse("solver '", solver, "' is not known: give one of", known);
}

} // namespace rcr

// Solvers of the contact problem behind one signature: settings in, report out.
//
// Each starts from problem.impulse (the warm start; zeros for a cold one), leaves the solution there and the body
// velocities in problem.velocity, and reports the residual (residual.hpp) of exactly what it left.
#pragma once

#include <string>
#include <vector>

#include "contact_problem.hpp"

namespace rcr {

struct Settings {
	double tolerance     = 1e-4; // residual at which to stop [-]; 0 runs all iterations
	int    maxIterations = 1000; // sweeps over all points
	int    checkInterval = 10;   // sweeps between two evaluations of the residual
	int    threads       = 1;
};

struct Report {
	int    iterations = 0;
	double residual   = 0;
	bool   converged  = true;

	/// Tolerance 0 asks for all iterations, so it is never reached.
	bool reached(const Settings& settings) const { return settings.tolerance > 0 && residual <= settings.tolerance; }
};

Report solveNlgs(ContactProblem&, const Settings&);     // plain Gauss–Seidel, the paper's
Report solveSor(ContactProblem&, const Settings&);      // over-relaxed by 1.3
Report solveNesterov(ContactProblem&, const Settings&); // Gauss–Seidel with momentum and restart
Report solveExact(ContactProblem&, const Settings&);    // reaches 1e-8 where sweeps stall

/// Runs the solver of that name: nlgs, sor, nesterov, exact, auto.
/// Throws std::invalid_argument for any other name, negative or NaN tolerance, less than one iteration.
Report solve(ContactProblem&, const std::string& solver, const Settings&);

/// The names that `solve` knows.
const std::vector<std::string>& solverNames();

} // namespace rcr

// Solvers of the contact problem behind one signature: settings in, report out.
//
// Each starts from problem.impulse (the warm start; zeros for a cold one), leaves the solution there and the body
// velocities in problem.velocity, and reports the residual (residual.hpp) of exactly what it left.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "problem/contact_problem.hpp"
#include "problem/reductions.hpp"

namespace rcr {

struct Settings {
	double tolerance     = 1e-4; // residual at which to stop [-]; 0 runs all iterations
	int    maxIterations = 1000; // sweeps over all points
	int    minIterations = 0;    // sweeps before anything but maxIterations may stop the solver
	int    checkInterval = 10;   // sweeps between two evaluations of the stop criteria
	int    threads       = 1;
	int    lanes         = 0;    // doubles per vector: 1, 4 or 8; 0 = as many as the processor has. Changes no bit.

	int    stallSweeps   = 0;    // stops where the residual has reached no new low in so many sweeps; 0: goes on

	/// Kinematic test, with the residual: by how much points still close, or slip where they should stick, over the typical
	/// velocity (residual.hpp, `violation`) [-]. The residual weighs these errors by the forces: in slow flow, large steps or
	/// long particles, 1e-4 of the forces can be as much as the flow itself. Infinity: no test.
	double violation = 0.01;

	/// The typical velocity is never less than this share of the velocities without contacts: at rest there is no other [-].
	double rest = 0.01;

	/// Velocities that are rounding [m/s]: an island whose points close and slip by less, RMS of w_nn |p − P_K(…)|, is solved. Bodies that
	/// fly together leave nothing else to solve.
	double rounding = 0;

	/// Sweeps that an iteration of the exact solver counts as, of maxIterations and in the report [-].
	int exactCost = 1;

	/// Compliance ε of the contacts of a step that has no solution (solve_yielding.cpp) [-]; 0: such a step ends anywhere. Used only
	/// where impulses prove that there is none, and beyond `mostImpulse`.
	double compliance = 0;

	/// Normal impulse beyond which contacts yield although rigid ones could bear it (step/drive.hpp) [N s].
	double mostImpulse = std::numeric_limits<double>::infinity();

	/// An earlier pass of this step has yielded, and so does this one where some sweeps do not solve it.
	bool yielded = false;

	/// The paper's criterion, instead of the above where it is met first: relative change of the mean normal impulse
	/// between two evaluations [-]. Lax: from a warm start 1e-3 is met at a residual of 1e-2. 0: not used.
	double meanForceChange = 0;

	Reductions reductions;

	/// The problem is the one that this workspace has solved last, but for biases and impulses: what was made of it stands.
	bool continued = false;
};

struct Report {
	int    iterations = 0;    // of the island that needs most
	double residual   = 0;    // of what was left [-]
	bool   converged  = true; // each island has met a criterion of the settings
	double violation  = 0;    // as in Settings, of what was left [-]
	bool   yielded    = false; // the step has no solution: its contacts have yielded, as Settings::compliance lets them
	double taken      = 0;     // energy that contacts take in the step, −Σ p · (u + b_n n) [J/m]
	double freeSpeed  = 0;     // RMS relative velocity without contact impulses [m/s]
	double closing    = 0;     // of a step that has yielded: the greatest speed at which a point still closes, −(u_n + b_n) [m/s]
	double grown      = std::numeric_limits<double>::infinity(); // change of all impulses in the last `probeSweeps` sweeps, over the impulses [-]; infinite: not known
	double work       = 0;    // sweeps × points, summed over the islands, each to its own convergence; without those between exact steps

	/// Tolerance 0 asks for all iterations, so it is never reached.
	bool reached(const Settings& settings) const { return settings.tolerance > 0 && residual <= settings.tolerance; }
};

class PackedProblem;
class Team;

/// What the sweep solvers keep between steps: threads, memory, and colours and order as long as all pairs last. It saves
/// time and changes no bit. Give the same one for each step of a simulation. Not for two threads at once.
class Workspace {
public:
	Workspace();
	~Workspace();
	PackedProblem& packed() { return *packed_; }
	Team&          team(); // for other loops of the same step: a run that holds all of it keeps the helpers awake
	ModelSummary   summary() const; // of the last problem
	int            layouts() const; // how often a problem had other pairs, needs or kinds of bodies than the one before
	double         layoutSeconds() const; // that colours and order have taken so far

private:
	std::unique_ptr<PackedProblem> packed_;
};

Report solveNlgs(ContactProblem&, const Settings&, Workspace&);     // plain Gauss–Seidel, the paper's
Report solveSor(ContactProblem&, const Settings&, Workspace&);      // over-relaxed by 1.3
Report solveNesterov(ContactProblem&, const Settings&, Workspace&); // Gauss–Seidel with momentum and restart
/// Reaches 1e-8 where sweeps stall. It begins with sweeps, unless it is told what those before it have left.
Report solveExact(ContactProblem&, const Settings&, Workspace&, const Report* swept = nullptr);

/// Lets the contacts yield, of the problem that this workspace has solved last and of what was left of it, as told by the report.
Report solveYielding(ContactProblem&, const Settings&, const Report&, Workspace&);
/// Whether the impulses grow without bound in further sweeps on the problem that this workspace has solved last (infeasibility.hpp).
bool growsWithoutBound(const ContactProblem&, const Settings&, Workspace&);

/// Runs the solver of that name: nlgs, sor, nesterov, exact, or auto, which sweeps down to 1e-6, without any friction further, and
/// takes the exact tier below, where 300 sweeps lead no further, or, up to 1000 points, where 300 do not do; its iterations count as
/// 20 sweeps there. Up to 1000 points it also aims at velocities finer by 1000 in `Settings::rest`, as far as a few sweeps and exact
/// steps lead; converged is what met the settings.
/// Throws std::invalid_argument, with what was given and what is wanted, for an unknown name, for settings out of range,
/// for a problem that checkProblem refuses.
Report solve(ContactProblem&, const std::string& solver, const Settings&, Workspace&);
Report solve(ContactProblem&, const std::string& solver, const Settings&);

/// What if the biases were others: sweeps with momentum on from the solution of the problem that was solved last in this
/// workspace. Its impulses stay; the velocities reached are written, and the stretch of the cell.
void sweepWithBias(const ContactProblem&, const std::vector<double>& bias, int sweeps, std::vector<Twist>& velocity, Vec2& stretch, Workspace&);

/// The names that `solve` knows.
const std::vector<std::string>& solverNames();

/// Throws std::invalid_argument, with what was given and what is wanted, for an unknown name or settings out of range.
void checkSettings(const std::string& solver, const Settings&);

} // namespace rcr

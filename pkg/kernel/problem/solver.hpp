// Methods that solve the contact problem: settings in, report out.
//
// solve/solve.hpp chooses among them.
//
// A solver starts from problem.impulse: the warm start, or zeros for a cold start. It writes the
// solution to problem.impulse and the velocities to problem.velocity. The report holds the errors
// (residual.hpp) of exactly these impulses.
#pragma once

#include <memory>

#include "problem/contact_problem.hpp"
#include "problem/settings.hpp"

namespace rcr {

struct Errors {
	double residual      = 0; // residual.hpp [-]
	double creep         = 0; // residual.hpp [m/s]
	double errorEstimate = 0; // error_estimate.hpp; infinity: unknown [-]

	/// Returns true if the residual and the creep meet their tolerances. Tolerance 0 is
	/// never met.
	bool meetsResidual(const Settings& s) const { return s.areMet(residual, creep, 0); }

	/// Returns true if residual and estimated error meet their limits. The residual 0 meets the
	/// tolerance 0.
	bool meets(const Settings& s) const
	{
		return s.areMet(residual, creep, errorEstimate)
		        || (s.tolerance == 0 && residual == 0);
	}
};

struct Report : Errors {
	int iterations = 0; // of the island that needs most
	/// Every island has met tolerance and accuracy or meanForceChange, or has the residual 0.
	/// `solve` revokes this if a blocked contact closes, or if an island exceeds an energy bound
	/// (infeasibility.hpp).
	bool   converged  = true;
	bool   yielded    = false; // contacts yielded, or the rigid step was found to be infeasible
	double dissipated = 0;     // energy dissipated by contacts, −Σ p · (u + b_n n) [J/m]
	double freeSpeed  = 0;     // RMS relative velocity without contact impulses [m/s]
	double mass       = 0;     // of the bodies with contacts, except hinged ones [kg]
	double work       = 0;     // Σ sweeps × points over islands, except sweeps after exact steps

	/// ‖Δp‖ over the last probeSweeps sweeps, relative to ‖p‖ [-]; infinity if not measured.
	double impulseGrowth = std::numeric_limits<double>::infinity();

	IslandShape         shape;   // of an island
	std::vector<Report> islands; // of each island

	/// This report with the iterations and the work of an earlier one added.
	Report plusCostOf(const Report& before) const
	{
		Report both = *this;
		both.iterations += before.iterations;
		both.work += before.work;
		return both;
	}

	/// Sets the verdicts, the counts and the dissipated energy from the reports of all islands.
	void combine(std::vector<Report> all)
	{
		converged = true, yielded = false;
		iterations = 0, work = 0, dissipated = 0, errorEstimate = 0;
		for (const Report& island : all) {
			converged  = converged && island.converged;
			yielded    = yielded || island.yielded;
			errorEstimate = std::max(errorEstimate, island.errorEstimate);
			iterations = std::max(iterations, island.iterations);
			work += island.work;
			dissipated += island.dissipated;
		}
		islands = std::move(all);
	}
};

class PackedProblem;
class ThreadTeam;

/// Data that sweep solvers keep between steps: threads, memory, colours and order of the pairs.
/// Pass the same workspace at every step of a simulation: this saves time, and results keep their
/// bits. Two threads must not use one workspace at the same time.
class Workspace {
public:
	Workspace();
	~Workspace();
	PackedProblem&      packed() { return *packed_; }
	ThreadTeam&         team();                // may be used for other loops of the same step
	const ModelSummary& summary() const;       // of the last problem
	double              layoutSeconds() const; // total time of all layouts [s]

private:
	std::unique_ptr<PackedProblem> packed_;
};

/// Impulses `probeSweeps` before the last sweep. They belong to islands whose report has a finite
/// impulseGrowth.
std::vector<LocalVector> impulsesBeforeProbe(Workspace&);

/// Over-relaxation of sor [-]. It saves a third of the sweeps in dense packings. At 1.6 the sweeps
/// cycle.
constexpr double sorRelaxation = 1.3;

/// Gauss–Seidel: plain (the solver of the paper), or over-relaxed as sor.
Report solveNlgs(ContactProblem&, const Settings&, Workspace&, double relaxation = 1);

/// Settings of an island from those of the problem.
using IslandSettings = Settings (*)(const Settings&, const IslandShape&);

/// The settings with the island's goal.
inline Settings settingsForGoal(const Settings& settings, const IslandShape& shape)
{
	return settings.forGoalOf(shape);
}

/// Sweeps with momentum and restart.
Report solveNesterov(
        ContactProblem&, const Settings&, Workspace&, IslandSettings = settingsForGoal);

/// Sweeps to a residual of about 1e-5; exact steps then begin (exact/).
Report sweepForExactSteps(ContactProblem&, const Settings&, Workspace&);

/// Exact steps reach 1e-8 where sweeps stall. `swept` is the report of the sweeps before. Runs at
/// most maxIterations further iterations. `cost`: of an exact iteration in sweeps, for maxIterations
/// and the report.
Report solveExact(
        ContactProblem&, const Settings&, const Report& swept, Workspace&, int cost = 1);

/// Solves with yielding contacts (sweep/solve_yielding.cpp).
Report solveYielding(ContactProblem&, const Settings&, Workspace&);

/// Sweeps with momentum from the impulses of the problem, with other biases. The workspace must
/// hold the problem, which does not change. Returns velocities and stretch rate only.
void sweepWithBias(const ContactProblem&, const std::vector<double>& bias, int sweeps,
        std::vector<PlanarVector>& velocity, Vec2& stretchRate, Workspace&);

} // namespace rcr

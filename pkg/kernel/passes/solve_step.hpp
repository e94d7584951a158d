// Solves a time step: passes of the solver until contacts and biases agree, then displacements.
//
//   repeat in at most ten passes:
//     solve → late contacts → biases       a new contact or bias requires a further pass
//   position correction → separation       displacements; velocities stay
//
// A late contact (detection/late_contacts.hpp) is one that the solved velocities close although the
// solve lacked it. Biases change after a large displacement (detection/large_displacements.hpp), and
// if restitution adds energy. The last pass is not reviewed: if it leaves out a late contact, the
// step has not converged. It needs no simulation: NumPy arrays suffice
// (python/kernel_steps.cpp).
#pragma once

#include "detection/late_contacts.hpp"
#include "problem/solver.hpp"
#include "step/yield_bounds.hpp"

namespace rcr {

/// What a simulation decides about a step.
struct StepHost : NewContacts {
	/// Called once after the passes and before displacements; may throw.
	std::function<void()>                            check = [] {};
	std::function<void(const char* stage, double s)> clock = [](const char*, double) {};
};

struct StepSettings {
	std::string solver = "auto";
	Settings    pass; // of a solve; yielding bounds, rounding and creep follow from the step
	double      correction      = 0.1; // share of an overlap that a step removes [-]
	double      yieldCompliance = 1;   // over the default [-]; 0: contacts never yield
	/// Grains are squeezed: ten times as many iterations, since a lack of them must not look like a
	/// jam.
	bool squeezed = false;
};

/// Result of a step: of the last pass, with iterations and work of all passes.
struct StepResult {
	bool   converged = true, yielded = false;
	bool   largeDisplacements = false; // of a contact
	int    iterations         = 0;
	double work = 0, residual = 0, errorEstimate = 0; // see Report
};

/// Solves the step. `step.problem` and `step.force` hold the solution, `step.displacement` and
/// `step.strain` the displacements. Throws what `host` throws.
StepResult solveStep(Step&, const StepSettings&, const StepHost&, Neighbors&, Workspace&);

/// Settings of a solve with these bounds.
Settings passSettings(const StepSettings&, const YieldBounds&);

/// Adds the contacts that a search has found to the step, with their laws.
void addFoundContacts(Step&, const NewContacts&);

} // namespace rcr

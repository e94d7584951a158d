// Engine that solves all rigid contacts of a step together: nonsmooth Contact Dynamics.
//
//   v⁺ = v⁻ + M⁻¹ (dt f + Jᵀ p)          f: gravity and forces of earlier engines [N/m]
//   0 ≤ u_n + b_n ⟂ p_n ≥ 0               u = J v⁺: velocity at a point [m/s]; p: impulse [N s/m]
//   |p_t| ≤ µ p_n, opposite to sliding    b_n: bias [m/s]
// b_n is gap/dt if the point is open or the step overdamped, e u_n⁻ if the point rebounds (e:
// restitution), else 0; b_n < 0 separates bodies. v⁻, v⁺: before and after the step; M: masses.
//
// Stages of a step, on arrays (kernel/step/step.hpp) from `gather` to `scatter`:
//   gather → solveStep → monitor → observe → scatter
//
// `gather` copies bodies, loads and contacts, with the last forces as initial impulses. solveStep
// (kernel/passes) finds impulses and shifts that remove overlaps. `monitor` counts the step, or
// throws at a jam. In O.run, ArraySteps takes up to 100 steps between gather and scatter. `scatter`
// adds forces p/dt and shifts to YADE's bodies; NewtonIntegrator moves them. Source: Moreau 1988,
// 1999; Jean 1999.
#pragma once

#include <thread>

#include "dem/records/EnergyAccount.hpp"
#include "dem/records/Published.hpp"
#include "dem/records/StepCost.hpp"
#include "dem/records/StepMonitor.hpp"
#include "dem/records/StepObserver.hpp"
#include "dem/validation/validation.hpp"
#include "kernel/passes/solve_step.hpp"

namespace yade {

class ArraySteps;

class ContactDynamics : public GlobalEngine, public RigidSolver {
public:
	void action() override;

	std::string attributeError() const override;
	// Python interface. Locks guard what a script may access during a run.
	boost::python::dict        problemDict() const;
	std::string                changeSinceStep() const;
	boost::python::dict takeObserved() { return observer_.takeMeans(get<&ContactDynamics::observe>()); }
	void                       endRun(const Scene& ended) { observer_.setLastPositions(ended); }
	boost::python::list        takeObservations() { return observer_.takeIntervals(); }
	boost::python::dict        modelDict() const { return get<&ContactDynamics::model_>().dict(); }
	boost::python::dict        secondsDict() const { return times_.dict(); }
	boost::python::dict        stepCounts() const;
	/// Reads or writes an attribute that another thread may use.
	template <auto Attribute> auto get() const -> std::decay_t<decltype(this->*Attribute)>
	{
		const std::lock_guard<std::mutex> lock(attributesMutex_);
		return this->*Attribute;
	}
	template <auto Attribute, class Value> void set(const Value& given)
	{
		const std::lock_guard<std::mutex> lock(attributesMutex_);
		this->*Attribute = given;
	}
	template <auto N> auto count() const { return get<&ContactDynamics::monitor>().steps.*N; }

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(ContactDynamics,GlobalEngine,
		"Solves all rigid contacts of a step together (nonsmooth Contact Dynamics, Moreau time stepping) and adds their forces to "
		"the bodies. It stands between :yref:`InteractionLoop` and :yref:`NewtonIntegrator`, whose damping must be 0. "
		"docs/law.md and docs/solvers.md describe the settings.",
		((Real,accuracy,0.01,,"Relative error of velocities and forces at which the solver stops [-], by :yref:`errorEstimate<ContactDynamics.errorEstimate>`. 30 times as much in dense packings with friction, whose solutions differ by 10 to 30 %. inf switches it off."))
		((Real,tolerance,1e-4,,"Residual that a solution must also meet [-]; 0 runs all iterations."))
		((int,maxIterations,1000,,"Sweeps that a step may take. Further passes, yielding contacts and squeezed grains may take more."))
		((std::string,solver,"auto",,""))
		((int,threads,0,,"Threads of the solver; 0: as many as YADE has (-j)."))
		((Real,correction,0.1,,"Share of an overlap beyond 1e-4 (R₁ + R₂) that a step removes, by shifts of at most 1e-4 R [-]. At 0, overlaps of curved paths remain too."))
		((Real,yieldCompliance,1,,"Compliance of yielding contacts over its default [-]. With a larger value, driven contacts yield at smaller impulses; 0: contacts never yield."))
		((bool,overdamped,false,,"Motion without inertia: free bodies start each step from rest, or from :yref:`flow<ContactDynamics.flow>`, and overlaps are removed completely. O.cell.homoDeform is 0 meanwhile in a periodic cell."))
		((Matrix3r,flow,Matrix3r::Zero(),,"Velocity gradient of the flow from which overdamped bodies start a step [1/s]. A periodic cell uses its velGrad instead."))
		((bool,trackMeanStretch,false,,"Overdamped bodies also start from the mean stretch of earlier steps, so that no drag resists it. Not in a periodic cell."))
		((std::vector<int>,observe,,,""))
		((int,observeEvery,0,Attr::noSave,"Number of steps in each entry of :yref:`observations<ContactDynamics.observations>`; 0 keeps no entries."))
		((Published<bool>,converged,true,Attr::readonly,"The last step met accuracy and tolerance (or meanForceChange), no contact yielded, and no late contact was left out. False also if two bodies span half of a periodic cell, or if large displacements of bodies with inertia left an overlap beyond 0.02 (R₁ + R₂)."))
		((Published<int>,iterations,0,Attr::readonly,"Sweeps of the last step over all its passes, those of the island with most sweeps. May exceed maxIterations."))
		((Published<double>,residual,0,Attr::readonly,"Residual of the last step: natural map of the contact laws relative to the impulses [-]."))
		((Published<double>,errorEstimate,0,Attr::readonly,"Estimated error of the last step, relative to its velocity changes and forces [-]: the distance to the solution that the solver approaches. inf: unknown."))
		((Published<int>,contactPoints,0,Attr::readonly,"Contact points of the last step, closed or within the alert distance."))
		((Published<bool>,yielded,false,Attr::readonly,"Contacts of the last step yielded: it had no solution, or only one with impulses that its drive and loads do not explain."))
		((Published<double>,unbalancedForce,0,Attr::readonly,"Mean net force on a free grain or clump over the mean normal force of closed points, in the last step [-]; inf without contacts."))
		((Published<double>,largestUnbalancedForce,0,Attr::readonly,"Largest net force on a free grain or clump over the mean normal force of closed points, in the last step [-]; inf without contacts."))
		((int,lanes,0,Attr::noSave,"Doubles per vector operation: 1, 4 or 8; 0: the processor's width. Results do not depend on it."))
		((bool,arrays,true,,"Take steps in arrays where the scene allows it (docs/solvers.md). Results do not depend on it."))
		((Real,meanForceChange,0,,"Also ends the solver, as converged, once the mean normal force changes relatively less than this in 10 sweeps [-]; 0: not used."))
		((Vector2r,meanStretchRate,Vector2r::Zero(),Attr::hidden,"Stretch rates along x and y that trackMeanStretch adds to the flow [1/s]."))
		((Vector2r,stretchChange,Vector2r::Zero(),Attr::hidden,"Change of meanStretchRate in the last step [1/s]."))
		((std::vector<int>,drivenBodies,,Attr::hidden,"Prescribed bodies that moved in the last step."))
		((std::vector<Vector3r>,drivenVelocities,,Attr::hidden,"Their velocities along x and y [m/s], and their angular velocities [rad/s]."))
		((StepMonitor,monitor,,Attr::hidden,"Counts of steps and overlaps."))
		((EnergyAccount,energy,,Attr::hidden,"Energy of the last step that O.energy does not hold yet.")),
		/* ctor */,
		.add_property("solver",&ContactDynamics::get<&ContactDynamics::solver>,&ContactDynamics::set<&ContactDynamics::solver,std::string>,"Solver: auto (default), nesterov, exact, sor or nlgs.")
		.add_property("observe",&ContactDynamics::get<&ContactDynamics::observe>,&ContactDynamics::set<&ContactDynamics::observe,std::vector<int>>,"Ids of bodies whose mean contact forces :yref:`observed<ContactDynamics.observed>` returns; clumps, not their members. A change starts a new mean.")
		.add_property("missedSteps",&ContactDynamics::count<&rcr::StepCounts::missed>,"Number of steps so far that did not converge, those without a solution included; 0 at tolerance 0.")
		.add_property("yieldedSteps",&ContactDynamics::count<&rcr::StepCounts::yielded>,"Number of steps so far in which contacts yielded.")
		.add_property("deepestOverlap",&ContactDynamics::count<&rcr::StepCounts::deepest>,"Deepest overlap at the beginning of a step so far, over R₁ + R₂ [-]. Pairs of prescribed bodies and overlaps that overdamped steps remove do not count.")
		.add_property("model",&ContactDynamics::modelDict,"Size of the last problem after all reductions, and how it was solved, as a dict.")
		.add_property("seconds",&ContactDynamics::secondsDict,"Wall time of all steps so far by stage, as a dict [s].")
		.def("observed",&ContactDynamics::takeObserved,"observed() → dict: counts, largest residual and mean contact forces since the last call. Each entry of observations restarts these means. docs/solvers.md has an example.")
		.def("observations",&ContactDynamics::takeObservations,"observations() → list of dicts: one entry per observeEvery steps since the last call, as observed() returns, with step, time and positions.")
		.def("_step_counts",&ContactDynamics::stepCounts,"Numbers of steps so far by outcome, deepest overlap, and largest error of missed steps, as a dict.")
		.def("_problem",&ContactDynamics::problemDict,"Arrays of the last contact problem as bytes, for ContactDynamics.save.")
		.def("_change_since_step",&ContactDynamics::changeSinceStep,"Names what has changed since the last step, so that pos − O.dt vel is no longer a body's position at the beginning of that step. Before NewtonIntegrator has run, velocities differ too. Empty: no change, or O.iter is not that of the last step.")
	);
	// clang-format on
	DECLARE_LOGGER;
private:
	/// Runs `work` and adds its duration to the stage.
	template <class Work> auto timed(const char* stage, Work work)
	{
		return rcr::timed([&](double seconds) { times_.add(stage, seconds); }, work);
	}
	int           solverThreads() const;
	rcr::StepSettings stepSettings() const;
	rcr::StepHost stepHost(const validation::Engines&);
	void          runSteps(const validation::Engines&);
	void          solveStep(const validation::Engines&);
	StepOutcome   stepOutcome() const;
	void          monitorStep();
	bool tracksStretch() const { return overdamped && trackMeanStretch && !scene->isPeriodic; }
	void          setStartFlow();
	void          storeDrives();
	void          updateMeanStretch();

	validation::Validator         validator_;
	rcr::Step                     step_; // the last step
	SceneHandles                  handles_;
	rcr::Neighbors                neighbors_;
	rcr::Workspace                workspace_; // threads, colouring and packed arrays
	std::shared_ptr<ArraySteps>   arraySteps_;
	rcr::StepResult               result_; // of the last step
	StepModel                     model_;
	StepObserver                  observer_;
	StageTimes                    times_;
	mutable std::mutex            attributesMutex_; // guards `solver`, `observe`, `monitor`, `model_`
	std::atomic<std::thread::id>  stepThread_; // this thread may read the problem during a run
};
REGISTER_SERIALIZABLE(ContactDynamics);

} // namespace yade

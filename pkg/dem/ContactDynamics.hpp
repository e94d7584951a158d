// The engine of rigid contacts: one step of nonsmooth Contact Dynamics.
//
//   v⁺ = v⁻ + M⁻¹ (dt f + Jᵀ p)          f: gravity and the forces of all engines before this one [N, per unit depth]
//   0 ≤ u_n + b_n ⟂ p_n ≥ 0               u = J v⁺ relative velocity of a point [m/s], p its impulse [N s]
//   |p_t| ≤ µ p_n, against the sliding
//
// The stages stand in files of their own (../kernel/step/step.hpp names them); `step` calls them in the order of the algorithm. The
// scene is read by the first and changed by the last alone, so that an exception at any place leaves it as it was. NewtonIntegrator
// then moves the bodies by the forces p/dt that were added. Source: Moreau 1988, 1999; Jean 1999.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include <core/Body.hpp>
#include <core/GlobalEngine.hpp>

#include "../kernel/parallel/thread_team.hpp"
#include "../kernel/problem/solver.hpp"
#include "../kernel/step/drive.hpp"
#include "../kernel/step/energy.hpp"
#include "../kernel/watch/missed_steps.hpp"
#include "../kernel/watch/squeeze.hpp"
#include "Gate.hpp"
#include "gather.hpp"

namespace yade {

class FlatSteps;

class ContactDynamics : public GlobalEngine {
public:
	void action() override;

	/// What is wrong with its attributes; empty: nothing.
	std::string wrong() const;

	boost::python::dict modelDict() const;
	boost::python::dict secondsDict() const;
	boost::python::dict missedDict() const;
	boost::python::dict problemDict() const;
	boost::python::dict observedDict();
	boost::python::list observationsList();

	// Attributes that a step reads and that a script may set while it does.
	std::string      solverName() const;
	void             setSolver(const std::string&);
	std::vector<int> observedIds() const;
	void             setObserve(const std::vector<int>&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(ContactDynamics,GlobalEngine,"Solves all rigid contacts of the step together (nonsmooth Contact Dynamics, Moreau time stepping). Takes the forces that other engines have put on the bodies and the gravity of :yref:`NewtonIntegrator`, finds the contact impulses that satisfy Signorini's and Coulomb's laws at the end of the step, and adds them as forces; :yref:`NewtonIntegrator` then moves the bodies. Stands after :yref:`InteractionLoop` and before :yref:`NewtonIntegrator`, whose damping must be 0. Bodies move in the plane: z, X and Y blocked. The time step is bound by accuracy, not by a stiffness. With ``O.trackEnergy`` it adds to ``O.energy`` what the contacts take: plastDissip (friction), impactDissip (normal impulses), driveWork (given to bodies of prescribed motion; negative where these drive) and correctionWork (potential energy that the position correction has given, negative; gravWork has its counterpart), so that ``O.energy.total()`` stays.",
		((Real,tolerance,1e-4,,"Residual at which the iterations stop [-]: natural map of the contact laws, relative to the impulses. :yref:`kinematicTolerance<ContactDynamics.kinematicTolerance>` must be met too. 0 runs :yref:`maxIterations<ContactDynamics.maxIterations>`"))
		((int,maxIterations,1000,,"Most sweeps a step; ≥ 1"))
		((int,minIterations,0,,"Sweeps before a criterion may stop the solver"))
		((Real,kinematicTolerance,0.01,,"Kinematic criterion, beside :yref:`tolerance<ContactDynamics.tolerance>`: velocities by which points still close, or slip where they should stick, RMS over the RMS relative velocity of all points, or over 1 % of the one without contacts, if that is larger [-]. Up to 1000 points, ``auto`` goes on to 1e-5 of the latter where some hundred sweeps, or exact steps as long as these, do that. inf: no such test"))
		((Real,meanForceChange,0,,"The paper's criterion, in the place of the others where it is met first: relative change of the mean normal force between two evaluations, 10 sweeps apart [-]. It is lax: from a warm start 1e-3 is met at a residual of 1e-2. 0: not used"))
		((std::string,solver,"auto",,"Name of the solver: nlgs, sor, nesterov, exact or auto"))
		((int,threads,0,,"Threads of the solver; 0: as many as YADE has (-j)"))
		((int,lanes,0,Attr::noSave,"Doubles that the solver works on at a time: 1, 4 or 8, which is 16 with AVX-512; 0: as many as the processor has. Changes no bit; not saved, it is the processor's"))
		((Real,correction,0.1,,"Share of an overlap beyond 1e-4 (R₁ + R₂) that is taken back each step by a position correction without velocity [-]; 0 switches it off. Impulses and velocities never see it."))
		((Real,yieldCompliance,1,,"How far contacts yield in a step without a solution, as a multiple of the yield at which they bear the loads and the momentum that a row of grains takes from the drive [-]. Driven walls can ask for more than rigid grains and friction can do: there is no solution, or one with forces beyond what loads and momentum account for. Such a step is solved with contacts that give way, and counted in :yref:`yieldedSteps<ContactDynamics.yieldedSteps>`. All other steps are rigid. 0: never"))
		((bool,overdamped,false,,"Motion without inertia: bodies start every step from rest (prescribed velocities stay; rest may be a :yref:`flow<ContactDynamics.flow>`), and overlaps are taken back whole within the step, since no velocity is kept of it. A step then goes down the potential energy as far as the time step allows and ends at rest where the forces balance. Restitution and :yref:`correction<ContactDynamics.correction>` do not apply."))
		((Matrix3r,flow,Matrix3r::Zero(),,"Velocity gradient of the homogeneous flow that bodies without inertia are at rest in [1/s]: a body at r starts an :yref:`overdamped<ContactDynamics.overdamped>` step with the velocity flow · r, and what resists is its motion relative to that. In a periodic cell the cell's velGrad takes its place"))
		((bool,trackMeanStretch,false,,"Whether the :yref:`flow<ContactDynamics.flow>` follows the bodies: what all moving bodies together stretch by along x and y, about the origin, they start the next step from, so that no drag resists it. Over a large sample even a little of it adds up to the stress of the walls. Only what changes from step to step has a drag. A periodic cell needs none of it"))
		((Vector2r,meanStretchRate,Vector2r::Zero(),Attr::readonly,"Rates by which the flow that follows stretches along x and y, beside :yref:`flow<ContactDynamics.flow>` [1/s]; 0 without :yref:`trackMeanStretch<ContactDynamics.trackMeanStretch>`"))
		((Vector2r,stretchChange,Vector2r::Zero(),Attr::hidden,"What the last step has added to `meanStretchRate`, and the impulses do not know yet"))
		((std::vector<std::string>,reductions,rcr::Reductions::names(),,"What the solver may drop where the scene does not need it, seen anew in each step; :yref:`model<ContactDynamics.model>` tells what is left. frictionless: pairs without friction carry one unknown a point. discs: where no normal has a lever, nothing turns without friction, and with it normal and tangential impulses know nothing of each other. fixed: bodies of prescribed motion have no unknowns. islands: what does not touch is solved apart, each to its own convergence. layout: order and colours are kept while the contacts last. All of them change nothing but the time; leave names out to compare"))
		((bool,arrays,true,,"Whether steps of an ``O.run`` are taken in arrays, without YADE's objects, where nothing looks at these in between: until a PyRunner or a recorder is due, or 100 steps are over. Changes no bit; :yref:`model<ContactDynamics.model>` tells which way steps went"))
		((std::vector<int>,observe,,,"Ids of bodies whose contact forces :yref:`observed<ContactDynamics.observed>` averages: clumps, not their members. A change of it begins anew"))
		((int,observeEvery,0,Attr::noSave,"Steps of each entry of :yref:`observations<ContactDynamics.observations>`; 0: none are kept. Not saved, and neither is what has been observed"))
		((int,iterations,0,Attr::readonly,"Sweeps of the last step, in the island that needs most, summed over its passes: one, and a further one each time the solution shows contacts that were not foreseen, gaps that close otherwise than their planes say, or restitution that gives energy"))
		((Real,residual,0,Attr::readonly,"Residual reached in the last step [-]"))
		((Real,kinematicError,0,Attr::readonly,"What :yref:`kinematicTolerance<ContactDynamics.kinematicTolerance>` bounds, after the last step [-]"))
		((bool,converged,true,Attr::readonly,"Whether the last step reached the tolerance and :yref:`kinematicTolerance<ContactDynamics.kinematicTolerance>`, and left no overlap beyond 0.02 of R₁ + R₂"))
		((int,contactPoints,0,Attr::readonly,"Contact points of the last step, closed or within the alert distance"))
		((Real,unbalancedForce,0,Attr::readonly,"Mean net force on a free particle over the mean contact force, in the last step [-], as utils.unbalancedForce; it falls to the tolerance of the solver as a packing comes to rest"))
		((Real,largestUnbalancedForce,0,Attr::readonly,"The same of the particle with the largest net force [-]"))
		((bool,yielded,false,Attr::readonly,"Whether the contacts of the last step have yielded (:yref:`yieldCompliance<ContactDynamics.yieldCompliance>`)"))
		((int,missedSteps,0,Attr::readonly,"Steps so far that have not :yref:`converged<ContactDynamics.converged>`"))
		((int,yieldedSteps,0,Attr::readonly,"Steps so far whose contacts have yielded"))
		((Real,deepestOverlap,0,Attr::readonly,"Deepest overlap of all steps so far, over R₁ + R₂ [-]"))
		((std::vector<Real>,watched,std::vector<Real>(6),Attr::hidden,"Steps; steps without a solution in the present squeeze; steps without a solution and overlap at the last warning; growth and depth of the present squeeze"))
		((std::vector<Real>,pendingEnergy,std::vector<Real>(4),Attr::hidden,"Friction, impacts, drive and lift of the last step [J], added to O.energy with the kinetic energy that they lead to"))
		((int,frictionIx,-1,(Attr::hidden|Attr::noSave),"Index of plastDissip"))
		((int,impactIx,-1,(Attr::hidden|Attr::noSave),"Index of impactDissip"))
		((int,driveIx,-1,(Attr::hidden|Attr::noSave),"Index of driveWork"))
		((int,correctionIx,-1,(Attr::hidden|Attr::noSave),"Index of correctionWork"))
		((int,gravityIx,-1,(Attr::hidden|Attr::noSave),"Index of gravWork")),
		/* ctor */,
		.add_property("model",&ContactDynamics::modelDict,"What the last step solved, as a dict. bodies: that an impulse can move; rotations: how many of these can turn; fixed: of prescribed motion, without unknowns; pairs, points: that can carry something; unknowns: one a point without friction, else two; frictionless: no point has friction; islands: solved apart; layouts: how often order and colours have been made in all steps so far; work: sweeps × points, summed over the islands; arrays: steps so far that were taken in arrays (:yref:`arrays<ContactDynamics.arrays>`); engines: why the step after the last one is left to YADE's engines.")
		.add_property("seconds",&ContactDynamics::secondsDict,"Wall time of all steps so far by what was done, as a dict: gather, layout (colours and order of the pairs), solve, scatter, arrays (the steps that these take), publish (from arrays to YADE's objects), late (bodies that go further than foreseen), adapt (biases to long ways, and to bounces that would give energy), correct [s].")
		.add_property("missed",&ContactDynamics::missedDict,"Steps that have not :yref:`converged<ContactDynamics.converged>`, as a dict: steps (all so far), missed, share (of all), yielded (those without a solution), deepest_overlap (over R₁ + R₂) [-].")
		.def("observed",&ContactDynamics::observedDict,"observed() → dict: what the steps since the last call came to, so that a run need not stop at each. steps; iterations (of all); residual (the largest); missed (steps that have not :yref:`converged<ContactDynamics.converged>`), yielded (those of them without a solution), missed_sum and missed_largest (of their residuals over the tolerance, or of their violations over :yref:`kinematicTolerance<ContactDynamics.kinematicTolerance>` where these are larger) [-]; forces: mean force (x, y) [N] and torque [N m] of the contacts on each body of :yref:`observe<ContactDynamics.observe>`, by id.")
		.def("observations",&ContactDynamics::observationsList,"observations() → list of dicts: what each :yref:`observeEvery<ContactDynamics.observeEvery>` steps since the last call came to, so that a long run has a history without a stop, or a PyRunner, that costs a look at all bodies. Each as :yref:`observed<ContactDynamics.observed>` tells it, which then tells of the steps since the last entry, and of the end of its last step: step (O.iter), time [s], points (contact points), last_iterations, last_residual; positions: (x, y) of each body of :yref:`observe<ContactDynamics.observe>` [m], by id.")
		.def("_problem",&ContactDynamics::problemDict,"The contact problem of the last step, for rcr.scene.save_problem: its arrays as bytes.")
		.add_property("solver",&ContactDynamics::solverName,&ContactDynamics::setSolver,"Name of the solver: nlgs, sor, nesterov, exact or auto")
		.add_property("observe",&ContactDynamics::observedIds,&ContactDynamics::setObserve,"Ids of bodies whose mean contact forces :yref:`observed<ContactDynamics.observed>` returns. Give a clump, not its members. A change starts a new mean.")
	);
	// clang-format on
	DECLARE_LOGGER;

private:
	template <class Work> void timed(const char* what, Work);

	int           solverThreads() const;
	rcr::Settings settings(const rcr::Drive&) const;
	rcr::Settings settingsOfFurtherPass(rcr::Settings) const;
	void          act();
	void          step(const gate::Engines&);
	void          solveAll(const gate::Engines&);
	/// What a solved pass shows. All but `accepted` ask for a further pass.
	enum class PassOutcome { accepted, missedContact, bounceLowered, biasesRestored, biasChanged };
	PassOutcome   reviewPass(const gate::Engines&, int pass, const rcr::Drive&, std::vector<double>& detected);
	PassOutcome   reviewLastPass(const gate::Engines&);
	bool          findMissedContacts(const gate::Engines&);
	bool          follows() const { return overdamped && trackMeanStretch && !scene->isPeriodic; }
	void          setRest();
	void          followStretch();
	void          solve(const rcr::Settings&);
	bool          takeInMissedContacts(const gate::Engines&);
	bool          adaptBiases(int pass);
	void          report(const rcr::Report&);
	void          refuseUnlessFinite() const;
	void          refuseFarStretch() const;
	void          measureUnbalance();
	void          observeStep(const std::vector<rcr::Twist>& loads);
	void          watch();
	rcr::Squeeze  squeeze() const;
	double        overlapOf(std::size_t point) const;
	double        overlapAtStart();
	void          bookEnergy(const std::vector<rcr::Twist>& loads, const Vector3r& gravity);

	struct Observed {
		std::vector<int>          ids; // of `observe`
		long                      steps = 0, iterations = 0, missed = 0, yielded = 0;
		double                    residual = 0, missedSum = 0, missedLargest = 0;
		std::map<int, rcr::Twist> force; // sums, by body [N, N m]
	};

	/// The same of `observeEvery` steps, and how the last of them ended.
	struct Observation {
		Observed                 of;
		long                     step = 0;
		double                   time = 0, residual = 0;
		int                      points = 0, iterations = 0;
		std::map<int, rcr::Vec2> position; // by body [m], of those that are still there
		bool                     placed = false; // not until the next step begins
	};

	boost::python::dict dictOf(const Observed&) const;
	template <class Place> void place(Place placeOf);
	void                        checkObserved() const;

	gate::Watch                   gate_;
	Observed                      observed_;
	std::vector<Observation>      observations_;
	mutable std::mutex            reading_; // guards all that Python may read or set during a step
	rcr::ModelSummary             summary_;  // of the last step
	std::string                   enginesReason_; // why the next step is left to YADE's engines; empty: it is not
	long                          fastSteps_ = 0;
	std::atomic<std::thread::id>  stepThread_;
	rcr::Step                     step_; // memory is kept between steps; the contents are of the last one
	StepSources                   sources_;
	std::shared_ptr<FlatSteps>    flat_;
	std::vector<rcr::Impulse>     warmStart_; // the impulses that the last problem was solved from
	rcr::Workspace                workspace_; // threads; colours and packed arrays, kept while the pairs last
	std::map<std::string, double> seconds_;
	double                        work_    = 0; // sweeps × points of the last step
	double                        overlap_ = 0; // deepest at the end of the step where bodies are displaced far, over R₁ + R₂
};
REGISTER_SERIALIZABLE(ContactDynamics);

} // namespace yade

#pragma once

#include <map>

#include <core/Body.hpp>
#include <core/GlobalEngine.hpp>

#include "../kernel/problem/solver.hpp"
#include "../kernel/parallel/team.hpp"
#include "../kernel/watch/missed_steps.hpp"
#include "../kernel/watch/squeeze.hpp"
#include "CurvedWays.hpp"
#include "LateContacts.hpp"

namespace yade {

class CdPhys;
class Interaction;
class NewtonIntegrator;
class RcrGeom;
struct Engines;

class ContactDynamics : public GlobalEngine {
public:
	void action() override;

	boost::python::dict modelDict() const;
	boost::python::dict secondsDict() const;
	boost::python::dict problemDict() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(ContactDynamics,GlobalEngine,"Solves all rigid contacts of the step together (nonsmooth Contact Dynamics, Moreau time stepping). Takes the forces that other engines have put on the bodies and the gravity of :yref:`NewtonIntegrator`, finds the contact impulses that satisfy Signorini's and Coulomb's laws at the end of the step, and adds them as forces; :yref:`NewtonIntegrator` then moves the bodies. Stands after :yref:`InteractionLoop` and before :yref:`NewtonIntegrator`, whose damping must be 0. Bodies move in the plane: z, X and Y blocked. The time step is bound by accuracy, not by a stiffness.",
		((Real,tolerance,1e-4,,"Residual at which the iterations stop [-]: natural map of the contact laws, relative to the impulses. :yref:`maxViolation<ContactDynamics.maxViolation>` must be met too. 0 runs :yref:`maxIterations<ContactDynamics.maxIterations>`"))
		((int,maxIterations,1000,,"Most sweeps a step; ≥ 1"))
		((int,minIterations,0,,"Sweeps before a criterion may stop the solver"))
		((Real,maxViolation,0.01,,"Kinematic criterion, beside :yref:`tolerance<ContactDynamics.tolerance>`: velocities by which points still close, or slip where they should stick, RMS over the RMS relative velocity of all points (or over 1 % of the one without contacts, if that is larger; 1e-5 of it where auto has up to 1000 points, whose exact steps are cheap) [-]. inf: no such test"))
		((Real,meanForceChange,0,,"The paper's criterion, in the place of the others where it is met first: relative change of the mean normal force between two evaluations, 10 sweeps apart [-]. It is lax: from a warm start 1e-3 is met at a residual of 1e-2. 0: not used"))
		((std::string,solver,"auto",,"Name of the solver: nlgs, sor, nesterov, exact or auto"))
		((int,threads,0,,"Threads of the solver; 0: as many as YADE has (-j)"))
		((int,lanes,0,Attr::noSave,"Doubles that the solver works on at a time: 1, 4 or 8; 0: as many as the processor has. Changes no bit; not saved, it is the processor's"))
		((Real,correction,0.1,,"Share of an overlap beyond 1e-4 (R₁ + R₂) that is taken back each step by a position correction without velocity [-]; 0 switches it off. Impulses and velocities never see it."))
		((Real,compliance,0.01,,"How far contacts yield in a step that has no solution, as a share of what their impulse alone would do [-]. Driven walls can ask for more than rigid grains and friction can do; such a step is solved with contacts that give way, and counted in :yref:`yieldedSteps<ContactDynamics.yieldedSteps>`. All other steps are rigid, to the bit. 0: never"))
		((bool,overdamped,false,,"Preparation without inertia: bodies start every step from rest (prescribed velocities stay), and overlaps are taken back whole within the step, since no velocity is kept of it. A step then goes down the potential energy as far as the time step allows and ends at rest where the forces balance. Restitution and :yref:`correction<ContactDynamics.correction>` do not apply."))
		((std::vector<std::string>,reductions,rcr::Reductions::names(),,"What the solver may drop where the scene does not need it, seen anew in each step; :yref:`model<ContactDynamics.model>` tells what is left. frictionless: pairs without friction carry one unknown a point. discs: without friction and levers nothing turns. fixed: bodies of prescribed motion have no unknowns. islands: what does not touch is solved apart, each to its own convergence. layout: order and colours are kept while the contacts last. All of them change nothing but the time; leave names out to compare"))
		((int,iterations,0,Attr::readonly,"Sweeps of the last step (of the island that needs most), of all its passes: one, and one more where contacts were not foreseen"))
		((Real,residual,0,Attr::readonly,"Residual reached in the last step [-]"))
		((Real,violation,0,Attr::readonly,"What :yref:`maxViolation<ContactDynamics.maxViolation>` bounds, after the last step [-]"))
		((bool,converged,true,Attr::readonly,"Whether the last step reached the tolerance"))
		((bool,yielded,false,Attr::readonly,"Whether the last step had no solution and its contacts have yielded (:yref:`compliance<ContactDynamics.compliance>`)"))
		((int,yieldedSteps,0,Attr::readonly,"Steps so far whose contacts have yielded"))
		((int,contactPoints,0,Attr::readonly,"Contact points of the last step, closed or within the alert distance"))
		((Real,unbalance,0,Attr::readonly,"Mean net force on a free particle over the mean contact force, in the last step [-], as utils.unbalancedForce; it falls to the tolerance of the solver as a packing comes to rest"))
		((Real,largestUnbalance,0,Attr::readonly,"The same of the particle with the largest net force [-]"))
		((int,missedSteps,0,Attr::readonly,"Steps so far that have missed the tolerance"))
		((Real,deepestOverlap,0,Attr::readonly,"Deepest overlap of all steps so far, over R₁ + R₂ [-]")),
		/* ctor */,
		.add_property("model",&ContactDynamics::modelDict,"What the last step solved, as a dict. bodies: that an impulse can move; rotations: how many of these can turn; fixed: of prescribed motion, without unknowns; pairs, points: that can carry something; unknowns: one a point without friction, else two; frictionless: no point has friction; islands: solved apart; layouts: how often order and colours have been made in all steps so far; work: sweeps × points, summed over the islands.")
		.add_property("seconds",&ContactDynamics::secondsDict,"Wall time of all steps so far by what was done, as a dict: gather, layout (colours and order of the pairs), solve, scatter, late (bodies that go further than foreseen), adapt (biases to long ways, and to bounces that would give energy), correct [s].")
		.def("_problem",&ContactDynamics::problemDict,"The contact problem of the last step, for rcr.scene.save_problem: its arrays as bytes.")
	);
	// clang-format on
	DECLARE_LOGGER;

private:
	/// One pair of bodies with its points points[first] … points[first + points − 1].
	struct Contact {
		RcrGeom*   geom = nullptr;
		CdPhys*    phys = nullptr;
		Body::id_t id1 = 0, id2 = 0;
		int        points = 0, first = 0;
	};

	/// Gap of a point and the least one that is left as it is.
	struct Gap {
		double now, allowed;
	};

	template <class Work> void timed(const char* what, Work);

	int           solverThreads() const;
	rcr::Settings settings() const;
	rcr::Settings settingsOfFurtherPass() const;
	void          step(const Engines&);
	void          gatherBodies(const NewtonIntegrator&);
	void          gatherBody(const Body&, const NewtonIntegrator&);
	void          findContacts();
	Contact       contactOf(Interaction&) const;
	void          gatherContacts();
	void          solve(const rcr::Settings&);
	void          report(const rcr::Report&);
	void          keepInteractionsTogether();
	void          keepForces();
	void          scatterForces();
	void          measureUnbalance();
	bool          adaptBiases(const Engines&, bool letGo);
	bool          restrainBounce(const Contact&);
	void          watch();
	void          correctPositions();
	void          keepColliderAhead();

	// of the present step only: bodies and interactions come and go
	std::vector<StepBody>     bodies_;
	std::vector<Contact>      found_;          // in the order of YADE's container
	std::vector<Contact>      contacts_;       // sorted by the ids
	std::vector<int>          firstOf_, next_; // a body: its first contact as body 1; where its next one goes
	std::vector<Gap>          gap_;            // a point
	rcr::ContactProblem       problem_;
	std::vector<rcr::Impulse> warmStart_; // the impulses that problem_ was solved from
	std::vector<rcr::Twist>   load_;      // a body: sum of its contact impulses and their moments
	std::vector<double>       shiftBias_; // of the position correction
	std::vector<rcr::Twist>   shiftVelocity_;

	rcr::Workspace                workspace_; // threads; colours and packed arrays, kept while the pairs last
	LateContacts                  late_;
	CurvedWays                    curved_;
	rcr::Squeeze                  squeeze_;
	rcr::MissedSteps              missedSteps_;
	std::map<std::string, double> seconds_;
	double                        work_ = 0; // sweeps × points of the last step
};
REGISTER_SERIALIZABLE(ContactDynamics);

} // namespace yade

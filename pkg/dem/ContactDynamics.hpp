#pragma once

#include <core/Body.hpp>
#include <core/GlobalEngine.hpp>

#include "../kernel/solver.hpp"

namespace yade {

class Interaction;
class NewtonIntegrator;
class RcrGeom;
class CdPhys;

class ContactDynamics : public GlobalEngine {
public:
	void action() override;

	boost::python::dict modelDict() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(ContactDynamics,GlobalEngine,"Solves all rigid contacts of the step together (nonsmooth Contact Dynamics, Moreau time stepping). Takes the forces that other engines have put on the bodies and the gravity of :yref:`NewtonIntegrator`, finds the contact impulses that satisfy Signorini's and Coulomb's laws at the end of the step, and adds them as forces; :yref:`NewtonIntegrator` then moves the bodies. Stands after :yref:`InteractionLoop` and before :yref:`NewtonIntegrator`, whose damping must be 0. Bodies move in the plane: z, X and Y blocked. The time step is bound by accuracy, not by a stiffness.",
		((Real,tolerance,1e-4,,"Residual at which the iterations stop [-]: natural map of the contact laws, relative to the impulses. Velocities that still close a contact must also be below 1 % of the typical one. 0 runs :yref:`maxIterations<ContactDynamics.maxIterations>`"))
		((int,maxIterations,1000,,"Most sweeps a step; ≥ 1"))
		((std::string,solver,"auto",,"Name of the solver: nlgs, sor, nesterov, exact or auto"))
		((int,threads,0,,"Threads of the solver; 0: as many as YADE has (-j)"))
		((Real,correction,0.1,,"Share of an overlap beyond 1e-4 (R₁ + R₂) that is taken back each step by a position correction without velocity [-]; 0 switches it off. Impulses and velocities never see it."))
		((int,iterations,0,Attr::readonly,"Sweeps of the last step"))
		((Real,residual,0,Attr::readonly,"Residual reached in the last step [-]"))
		((bool,converged,true,Attr::readonly,"Whether the last step reached the tolerance"))
		((int,contactPoints,0,Attr::readonly,"Contact points of the last step, closed or within the alert distance"))
		((Real,unbalance,0,Attr::readonly,"Largest net force on a free body over the mean contact force, in the last step [-]; it falls to the tolerance of the solver as a packing comes to rest"))
		((bool,warned,false,Attr::hidden,"A run that misses its tolerance says so once")),
		/* ctor */,
		.add_property("model",&ContactDynamics::modelDict,"What the last step solved, as a dict: bodies, pairs, points, frictionless.")
	);
	// clang-format on
	DECLARE_LOGGER;

private:
	/// One pair of bodies with its points points[first] … points[first + geom.points − 1].
	struct Contact {
		Interaction* interaction;
		Body::id_t   id1, id2;
		int          first;
	};

	int                     solverThreads() const;
	const NewtonIntegrator& checkedIntegrator() const;
	void                    checkBodies() const;
	void                    gatherBodies(const NewtonIntegrator&);
	void                    findContacts();
	void                    gatherContacts();
	void                    scatterForces();
	void                    measureUnbalance();
	void                    correctPositions();
	void                    keepColliderAhead() const;

	std::vector<Contact> contacts_;          // of the present step only, sorted by the ids: interactions come and go
	std::vector<Contact> found_, lastFound_; // in the order of YADE's container
	std::vector<int>     order_;             // found_[order_[k]] is contacts_[k]
	rcr::ContactProblem  problem_;
	rcr::ContactProblem  shift_;                      // of the position correction
	rcr::Workspace       workspace_, shiftWorkspace_; // colours and packed arrays, kept while the contacts last
	bool                 frictionless_ = true;
};
REGISTER_SERIALIZABLE(ContactDynamics);

} // namespace yade

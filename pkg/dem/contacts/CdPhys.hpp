// Rigid contacts: their data, functor of the materials, and law.
#pragma once

#include <atomic>

#include "dem/contacts/RcrGeom.hpp"
#include "kernel/problem/contact_law.hpp"

namespace yade {

class CdPhys : public FrictPhys {
public:
	~CdPhys() override;

	/// The coefficients as one record, from and to the attributes.
	virtual rcr::ContactLaw law() const;
	void                    setLaw(const rcr::ContactLaw&);

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(CdPhys,FrictPhys,
		"Rigid contact with Coulomb friction for :yref:`ContactDynamics`, without stiffness (kn = ks = 0). The solver starts the "
		"next step from the forces of each point. normalForce and shearForce are the sums over the points.",
		((Real,restitution,0,,"Newton's coefficient of restitution, 0 (plastic) to 1 (elastic) [-]."))
		((Real,adhesion,0,,"Pull $f_a$ of each contact point whose gap is within the slop, 1e-4 (R₁ + R₂) [N]. Coulomb friction bears $\\mu(f_n+f_a)$."))
		((Real,rollingFriction,0,,"Coefficient $\\mu_r$ of rolling resistance [-]: the moment of a contact of one point is at most $\\mu_r(R_1+R_2)f_n$; an obstacle has the R of the grain."))
		((Real,rollingMoment,0,Attr::readonly,"Moment of rolling resistance on body 2 [N m]."))
		RCR_POINT_FORCES
		((Vector2r,bias,Vector2r::Zero(),Attr::readonly,"Bias b_n of each point in 0 ≤ u_n + b_n ⟂ f_n ≥ 0 [m/s].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(CdPhys, FrictPhys);
};
REGISTER_SERIALIZABLE(CdPhys);

class Ip2_FrictMat_FrictMat_CdPhys : public IPhysFunctor {
public:
	~Ip2_FrictMat_FrictMat_CdPhys() override;
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&,
	        const shared_ptr<Interaction>&) override;
	FUNCTOR2D(FrictMat, FrictMat);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Ip2_FrictMat_FrictMat_CdPhys,IPhysFunctor,
		"Creates a :yref:`CdPhys` from two :yref:`FrictMats<FrictMat>` when a contact forms. Friction is the smaller of the two "
		"friction angles unless frictAngle is set; young and poisson are not used.",
		((shared_ptr<MatchMaker>,frictAngle,,,":yref:`MatchMaker` of the friction angle [rad]; ``None``: the smaller one."))
		((shared_ptr<MatchMaker>,restitution,,,":yref:`MatchMaker` of the coefficient of restitution, 0 to 1 [-]; a number applies to all pairs; ``None``: 0."))
		((shared_ptr<MatchMaker>,adhesion,,,":yref:`MatchMaker` of :yref:`CdPhys.adhesion` [N]; a number applies to all pairs; ``None``: 0."))
		((shared_ptr<MatchMaker>,rollingFriction,,,":yref:`MatchMaker` of :yref:`CdPhys.rollingFriction` [-]; a number applies to all pairs; ``None``: 0."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(Ip2_FrictMat_FrictMat_CdPhys);

class Law2_RcrGeom_CdPhys_SignoriniCoulomb : public LawFunctor {
public:
	~Law2_RcrGeom_CdPhys_SignoriniCoulomb() override;
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	FUNCTOR2D(RcrGeom, CdPhys);
	// clang-format off
	YADE_CLASS_BASE_DOC(Law2_RcrGeom_CdPhys_SignoriniCoulomb,LawFunctor,
		"Rigid contact law without stiffness: $0\\leq u_n+b_n\\perp f_n\\geq 0$ (Signorini, with Newton's restitution) and Coulomb "
		"friction. It carries the forces of a contact to the next step; :yref:`ContactDynamics` solves all contacts together.");
	// clang-format on

private:
	std::atomic<long> checked_ { -1 }; // last iteration in which the engines were checked
};
REGISTER_SERIALIZABLE(Law2_RcrGeom_CdPhys_SignoriniCoulomb);

} // namespace yade

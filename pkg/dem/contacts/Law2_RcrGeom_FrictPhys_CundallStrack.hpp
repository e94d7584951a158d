// Springs: a spring, a dashpot and a Coulomb slider with a spring at each point of RcrGeom.
//
//   f_n = max(0, k_n δ − c u_n) − f_a    δ = −g > 0: overlap [m]; u = v₂ − v₁ at the point [m/s]
//   f_t ← f_t − k_s u_t dt, |f_t| ≤ µ (f_n + f_a)      f_a = `adhesion`
//   c   = 2 ζ √(k_n m₁m₂/(m₁ + m₂))      ζ = `damping`; a fixed body has an infinite mass
//
// Forces act on body 2; the tangent is the normal rotated by +90°. k_n, k_s [N/m] and µ come from
// FrictPhys. They apply to each point, so a side-side contact with two points is twice as stiff.
// Source: Cundall and Strack 1979.
//
// Where two sides slide off each other, both points meet. So the force and the energy
// U = k_n δ²/2 − f_a δ of the shallower point have the weight
//
//   w = s² (3 − 2 s), s = min(1, L/L₀)   L: length of the shadow, L₀ = 0.1 min(R₁, R₂)
//
// and the edge force −∂(w U)/∂x acts along the tangent, where x is the displacement of body 2. Then
// springs without friction have a potential.
//
// A contact of one point resists rolling with the moment M on body 2:
//
//   M ← M − k_r (ω₂ − ω₁) dt, |M| ≤ µ_r ℓ (f_n + f_a)    µ_r = `rollingFriction`, k_r = k_s R²
//
// with the smaller R, and ℓ = R₁ + R₂, or the R of the grain at an obstacle. Of equal discs, k_r
// adds nothing to the highest frequency. Source: Iwashita and Oda 1998.
#pragma once

#include "dem/contacts/RcrGeom.hpp"
#include "dem/shapes/planeConversion.hpp"

namespace yade {

class RcrFrictPhys : public FrictPhys {
public:
	RcrFrictPhys(const FrictPhys& yadePhys);
	~RcrFrictPhys() override;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RcrFrictPhys,FrictPhys,
		"A :yref:`FrictPhys` with a force per contact point. :yref:`Law2_RcrGeom_FrictPhys_CundallStrack` creates it.",
		RCR_POINT_FORCES
		((Vector2r,edge,Vector2r::Zero(),Attr::readonly,"Edge force at each point, part of its tangential force [N]: at the shallower of two points whose sides slide off each other."))
		((Real,rollingMoment,0,Attr::readonly,"Moment of rolling resistance on body 2 [N m].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RcrFrictPhys, FrictPhys);
};
REGISTER_SERIALIZABLE(RcrFrictPhys);

class Law2_RcrGeom_FrictPhys_CundallStrack : public LawFunctor {
public:
	~Law2_RcrGeom_FrictPhys_CundallStrack() override;
	void postLoad(Law2_RcrGeom_FrictPhys_CundallStrack&);
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	FUNCTOR2D(RcrGeom, FrictPhys);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Law2_RcrGeom_FrictPhys_CundallStrack,LawFunctor,
		"Contact law of springs on the geometry of :yref:`RcrGeom`: per point a spring $k_n$, a dashpot, and a Coulomb slider with a spring "
		"$k_s$. Stiffnesses come from :yref:`Ip2_FrictMat_FrictMat_FrictPhys`. ``rcr.critical_time_step()`` bounds the time step.",
		((Real,damping,0,Attr::triggerPostLoad,"Fraction ζ of the critical damping [-]: dashpot $c=2\\zeta\\sqrt{k_n m_1m_2/(m_1+m_2)}$ along the normal; 0: none."))
		((Real,adhesion,0,Attr::triggerPostLoad,"Pull $f_a$ of each point that overlaps [N]; Coulomb friction bears $\\mu(f_n+f_a)$."))
		((Real,rollingFriction,0,Attr::triggerPostLoad,"Coefficient $\\mu_r$ of rolling resistance [-]: the moment of a contact of one point is at most $\\mu_r(R_1+R_2)(f_n+f_a)$; an obstacle has the R of the grain. Its stiffness is $k_s R^2$, with the smaller R."))
		((int,deepOverlapCount,0,Attr::readonly,"Contacts with deep overlaps, summed over steps: beyond a tenth of the smaller cap radius and 0.02 (R₁ + R₂). The first one prints a warning."))
		((int,elasticIx,-1,(Attr::hidden|Attr::noSave),"Index of elastPotential."))
		((int,plasticIx,-1,(Attr::hidden|Attr::noSave),"Index of plastDissip."))
		((int,viscousIx,-1,(Attr::hidden|Attr::noSave),"Index of viscDissip."))
		((int,driveIx,-1,(Attr::hidden|Attr::noSave),"Index of driveWork."))
	);
	// clang-format on

private:
	DECLARE_LOGGER;
	rcr::LocalVector pointForce(const FrictPhys&, double dashpot, double overlap, double weight,
	        const rcr::LocalVector& u, double tangential);
	Real rollingMoment(const RcrGeom&, const RcrFrictPhys&, double spin, double normalForce);
	void applyForce(Body::id_t, const rcr::PlanarVector& force);
	void watchOverlap(const RcrGeom&, const FrictPhys&, const Interaction&);
};
REGISTER_SERIALIZABLE(Law2_RcrGeom_FrictPhys_CundallStrack);

} // namespace yade

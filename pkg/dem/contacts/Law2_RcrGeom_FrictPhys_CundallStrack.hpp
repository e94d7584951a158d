// The smooth law on the points of RcrGeom: a spring, a dashpot and a Coulomb slider with a spring at each (Cundall and
// Strack 1979), forces on body 2, tangent = normal turned by +90°:
//
//   f_n = max(0, k_n δ − c u_n)          δ = −g > 0 the overlap [m], u = v₂ − v₁ at the point [m/s]
//   f_t ← f_t − k_s u_t dt, |f_t| ≤ µ f_n
//   c   = 2 ζ √(k_n m₁m₂/(m₁ + m₂))      ζ = `damping`; a fixed body has an infinite mass
//
// k_n, k_s [N/m] and µ come from FrictPhys and belong to one point: a side-side contact with two is twice as stiff.
#pragma once

#include <core/Dispatching.hpp>
#include <pkg/dem/FrictPhys.hpp>

#include "dem/contacts/RcrGeom.hpp"
#include "dem/shapes/plane.hpp"

namespace yade {

class RcrFrictPhys : public FrictPhys {
public:
	RcrFrictPhys(const FrictPhys&);
	virtual ~RcrFrictPhys() = default;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RcrFrictPhys,FrictPhys,"A :yref:`FrictPhys` with a force per contact point. :yref:`Law2_RcrGeom_FrictPhys_CundallStrack` creates it.",
		((int,points,0,Attr::readonly,"Number of contact points that carry the forces"))
		((Vector2r,along,Vector2r::Zero(),Attr::readonly,"Place of each point, as :yref:`RcrGeom.along` [m]"))
		((Vector2r,force1,Vector2r::Zero(),Attr::readonly,"Force at the first point on body 2, (normal, tangential) [N]; the tangent is the normal turned by +90° about z"))
		((Vector2r,force2,Vector2r::Zero(),Attr::readonly,"Force at the second point [N]")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RcrFrictPhys, FrictPhys);
};
REGISTER_SERIALIZABLE(RcrFrictPhys);

class Law2_RcrGeom_FrictPhys_CundallStrack : public LawFunctor {
public:
	void postLoad(Law2_RcrGeom_FrictPhys_CundallStrack&);
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	FUNCTOR2D(RcrGeom, FrictPhys);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Law2_RcrGeom_FrictPhys_CundallStrack,LawFunctor,"Smooth contact law, the alternative to :yref:`ContactDynamics` on the same geometry: at each contact point a linear spring $k_n$, a dashpot, and a Coulomb slider with a spring $k_s$. Physics are YADE's own, from :yref:`Ip2_FrictMat_FrictMat_FrictPhys`; $k_n$ and $k_s$ belong to one point, so that a side-side contact with two points is twice as stiff. Open gaps feel nothing. The time step is bound by the stiffness: ``rcr.critical_time_step()``. With ``O.trackEnergy`` it adds elastPotential, plastDissip, viscDissip and driveWork (given to bodies of prescribed motion) to ``O.energy``.",
		((Real,damping,0,Attr::triggerPostLoad,"Share ζ of the critical damping of two bodies that meet at one point [-]: a dashpot $c=2\\zeta\\sqrt{k_n m_1m_2/(m_1+m_2)}$ along the normal. The total force never pulls. 0: none; use it or :yref:`NewtonIntegrator.damping`"))
		((int,deepOverlapCount,0,Attr::readonly,"How often a contact has overlapped by more than half the thinner body's radius (:yref:`capRadius<Rcr.capRadius>` of an :yref:`Rcr`), each step and contact by itself: springs too soft for what presses them, through which bodies may pass. The first one is told"))
		((int,elasticIx,-1,(Attr::hidden|Attr::noSave),"Index of elastPotential"))
		((int,plasticIx,-1,(Attr::hidden|Attr::noSave),"Index of plastDissip"))
		((int,viscousIx,-1,(Attr::hidden|Attr::noSave),"Index of viscDissip"))
		((int,driveIx,-1,(Attr::hidden|Attr::noSave),"Index of driveWork"))
	);
	// clang-format on

private:
	DECLARE_LOGGER;
	void watchOverlap(const RcrGeom&, const FrictPhys&, const Interaction&);
	void trackDrive(const State&, const rcr::Twist& load, double dt);
	void trackEnergy(const FrictPhys&, double overlap, double dashpotWork, double slider, double slip);
};
REGISTER_SERIALIZABLE(Law2_RcrGeom_FrictPhys_CundallStrack);

} // namespace yade

#pragma once

#include <core/Dispatching.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/MatchMaker.hpp>
#include <pkg/dem/FrictPhys.hpp>

namespace yade {

class CdPhys : public FrictPhys {
public:
	virtual ~CdPhys() = default;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(CdPhys,FrictPhys,"Rigid contact with Coulomb friction for :yref:`ContactDynamics`: no stiffness (kn = ks = 0). The forces of the last step are kept a point; they start the next step's iterations, and are saved with the scene. :yref:`normalForce<NormPhys.normalForce>` and :yref:`shearForce<NormShearPhys.shearForce>` are the sums of the two points.",
		((Real,restitution,0,,"Newton's coefficient of restitution, 0 (plastic) to 1 (elastic) [-]"))
		((int,points,0,Attr::readonly,"Number of contact points that carry the forces"))
		((Vector2r,along,Vector2r::Zero(),Attr::readonly,"Place of each point, as :yref:`RcrGeom.along` [m]"))
		((Vector2r,force1,Vector2r::Zero(),Attr::readonly,"Force at the first point on body 2, (normal, tangential) [N]; the tangent is the normal turned by +90° about z"))
		((Vector2r,force2,Vector2r::Zero(),Attr::readonly,"Force at the second point [N]"))
		((Vector2r,bias,Vector2r::Zero(),Attr::readonly,"b_n of each point in 0 ≤ u_n + b_n ⟂ f_n ≥ 0 [m/s]: gap/dt where it is open, restitution where it bounces")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(CdPhys, FrictPhys);
};
REGISTER_SERIALIZABLE(CdPhys);

class Ip2_FrictMat_FrictMat_CdPhys : public IPhysFunctor {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&, const shared_ptr<Interaction>&) override;
	FUNCTOR2D(FrictMat, FrictMat);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Ip2_FrictMat_FrictMat_CdPhys,IPhysFunctor,"Creates a :yref:`CdPhys` from two :yref:`FrictMats<FrictMat>`. Friction follows YADE's rule: the smaller of the two friction angles unless :yref:`frictAngle<Ip2_FrictMat_FrictMat_CdPhys.frictAngle>` says otherwise. As everywhere in YADE it is set when the contact is made; ``utils.setContactFriction`` changes existing contacts too. Young's modulus and Poisson's ratio are not used.",
		((shared_ptr<MatchMaker>,frictAngle,,,":yref:`MatchMaker` of the friction angle [rad]; ``None``: the smaller one"))
		((shared_ptr<MatchMaker>,restitution,,,":yref:`MatchMaker` of the coefficient of restitution, 0 to 1 [-]; a number stands for all pairs; ``None``: 0"))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(Ip2_FrictMat_FrictMat_CdPhys);

} // namespace yade

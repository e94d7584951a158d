#pragma once

#include <atomic>

#include "dem/contacts/CdPhys.hpp"
#include "dem/contacts/RcrGeom.hpp"

namespace yade {

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

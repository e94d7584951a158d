// Can the InteractionLoop make the contacts that ContactDynamics serves?
//
// YADE ends the process where it finds no law for a contact (exit(1)) or no physics (an exception in a parallel loop). So the
// Ig2 functors make no contact where ContactDynamics, which comes later in the same step, is going to say what is missing.
#pragma once

#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>

#include "CdPhys.hpp"
#include "ContactDynamics.hpp"
#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"
#include "RcrGeom.hpp"

namespace yade {

/// What a scene with ContactDynamics lacks, and what to do; empty where nothing is missing.
inline std::string missingFunctor(const Scene& scene)
{
	bool             served = false;
	InteractionLoop* loop   = nullptr;
	for (const auto& engine : scene.engines) {
		if (engine->dead) continue;
		served |= dynamic_cast<ContactDynamics*>(engine.get()) != nullptr;
		if (!loop) loop = dynamic_cast<InteractionLoop*>(engine.get());
	}
	if (!served || !loop) return {};
	bool                 swap;
	shared_ptr<Material> material = boost::make_shared<FrictMat>();
	if (!dynamic_cast<Ip2_FrictMat_FrictMat_CdPhys*>(loop->physDispatcher->getFunctor2D(material, material, swap).get()))
		return "the InteractionLoop has no Ip2_FrictMat_FrictMat_CdPhys for two FrictMats; put it into its second list.";
	shared_ptr<IGeom> geom = boost::make_shared<RcrGeom>();
	shared_ptr<IPhys> phys = boost::make_shared<CdPhys>();
	if (!dynamic_cast<Law2_RcrGeom_CdPhys_SignoriniCoulomb*>(loop->lawDispatcher->getFunctor2D(geom, phys, swap).get()))
		return "the InteractionLoop has no Law2_RcrGeom_CdPhys_SignoriniCoulomb; put it into its third list.";
	return {};
}

} // namespace yade

// Can the InteractionLoop make the contacts that ContactDynamics serves? And are they of one law?
//
// YADE ends the process where it finds no law for a contact (exit(1)) or no physics (an exception in a parallel loop). So the
// Ig2 functors make no contact where something is missing or laws are mixed. ContactDynamics, which comes later in the same
// step, says what it is; in a scene without it the Ig2 functor does, by refuseLater.
#pragma once

#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>

#include "CdPhys.hpp"
#include "ContactDynamics.hpp"
#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"
#include "Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "RcrGeom.hpp"

namespace yade {

/// An engine that is not dead, and the first functor of a kind; null if there is none.
template <class EngineType> inline EngineType* livingEngine(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (auto* found = engine->dead ? nullptr : dynamic_cast<EngineType*>(engine.get())) return found;
	return nullptr;
}

template <class FunctorType, class Dispatcher> inline bool has(const Dispatcher& dispatcher)
{
	return std::any_of(dispatcher->functors.begin(), dispatcher->functors.end(), [](const auto& f) { return bool(dynamic_cast<FunctorType*>(f.get())); });
}

/// What mixes the rigid and the smooth law, and what to do; empty where nothing does.
inline std::string mixedLaws(const InteractionLoop& loop, bool served)
{
	const char* rigid = served ? "the engine ContactDynamics"
	        : has<Law2_RcrGeom_CdPhys_SignoriniCoulomb>(loop.lawDispatcher) ? "Law2_RcrGeom_CdPhys_SignoriniCoulomb"
	        : has<Ip2_FrictMat_FrictMat_CdPhys>(loop.physDispatcher)        ? "Ip2_FrictMat_FrictMat_CdPhys"
	                                                                        : nullptr;
	if (!rigid || !has<Law2_RcrGeom_FrictPhys_CundallStrack>(loop.lawDispatcher)) return {};
	return std::string("O.engines mix Law2_RcrGeom_FrictPhys_CundallStrack, the smooth law, with ") + rigid
	        + ". Smooth contacts want Ip2_FrictMat_FrictMat_FrictPhys, this law and no ContactDynamics; rigid ones "
	          "Ip2_FrictMat_FrictMat_CdPhys, Law2_RcrGeom_CdPhys_SignoriniCoulomb and ContactDynamics before the NewtonIntegrator.";
}

/// What a scene lacks for its law, and what to do; empty where nothing is missing.
inline std::string missingFunctor(const Scene& scene)
{
	const bool             served = livingEngine<ContactDynamics>(scene);
	const InteractionLoop* loop   = livingEngine<InteractionLoop>(scene);
	if (!loop) return {};
	const std::string mixed = mixedLaws(*loop, served);
	if (!served || !mixed.empty()) return mixed;
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

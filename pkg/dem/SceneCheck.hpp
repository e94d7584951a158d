// What ContactDynamics cannot serve is refused: each function throws std::invalid_argument that says what was found, what is
// wanted and what to do.
#pragma once

#include <core/Interaction.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>
#include <pkg/dem/NewtonIntegrator.hpp>

#include "CdPhys.hpp"
#include "Rcr.hpp"

namespace yade {

[[noreturn]] void refuse(const std::string& message);

/// The engines that ContactDynamics works with.
struct Engines {
	const NewtonIntegrator& integrator;
	const InteractionLoop&  loop;
};

/// Refuses a time step, a periodic cell, engines and functors with which the contacts could not be solved.
Engines checkedEngines(const Scene&);

/// A body that takes part: finite numbers, motion in the plane, a mass where it is free, no clump. Forces must be synced.
void checkBody(const Body&, Scene&);
void checkParticle(const Body&, const Rcr&, Scene&);

/// A pair that no Ig2 functor serves: YADE would let the two bodies pass through each other.
void checkServed(const Interaction&, const Scene&);

/// Friction and restitution of a contact.
void checkPhys(const CdPhys&, Body::id_t id1, Body::id_t id2);

} // namespace yade

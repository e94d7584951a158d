// Contacts that the InteractionLoop has not made: filter and law.
#pragma once

#include "dem/validation/validation.hpp"

namespace yade {

struct ContactLaw {
	double friction, restitution;
};
/// Friction and restitution of a new contact, by the Ip2 functor of the scene.
ContactLaw contactLaw(Scene&, const InteractionLoop&, Body::id_t id1, Body::id_t id2);

/// Returns true if the collider and the functors of the scene allow a contact of the two bodies.
/// Throws if no Ig2 functor handles bodies that could overlap.
bool allowsContact(Scene&, const validation::Engines&, Body::id_t id1, Body::id_t id2);

} // namespace yade

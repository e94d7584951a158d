// From a solved step to YADE's objects: the last stage, and the only one that changes the scene.
#pragma once

#include "gather.hpp"

namespace yade {

/// Sum of the contact impulses on each body and their moments about its centre [N s, N m s]; of a clump on its members.
std::vector<rcr::Twist> loadsOf(const rcr::Step&);

/// Velocities that are not prescribed become those of a body without inertia.
void stop(State&, const rcr::Twist& rest);

/// Moves a body by a displacement of the position correction.
void displace(State&, const rcr::Twist& by);

/// Forces of contacts, forces on bodies, contacts that were missed, displacements, and velocities that an overdamped step starts from.
void scatter(Scene&, rcr::ThreadTeam&, const std::vector<rcr::Twist>& loads, StepSources&, rcr::Step&);

/// YADE's container is in the order in which interactions came and went. Where it is sorted by bodies, a body is still at hand when its
/// next interaction comes, here as in InteractionLoop, which takes a fifth to a third less time for 13 000 particles.
void keepInteractionsTogether(Scene&, const StepSources&);

} // namespace yade

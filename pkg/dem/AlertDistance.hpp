// How far ahead contacts are seen.
//
// A contact must be known to the law before it closes: 0 ≤ u_n + g/dt acts on open gaps too. A gap closes within one step
// if g < dt |relative speed at the end of the step|. That speed is not known yet, so twice the present one is taken, and
// never less than 1 % of the cap radius, which covers what starts from rest:
//
//   alert distance of a pair  = e₁ + e₂,   e = max(0.01 R', 2 dt (|v| + |ω| R), what is foreseen)
//
// Where the solution shows that a body goes further than its e, ContactDynamics foresees that and looks again within the
// step. e is a property of one body, so that its bounding box, enlarged by e, holds all that it can meet.
#pragma once

#include <algorithm>

#include "Rcr.hpp"
#include "plane.hpp"

namespace yade {

inline double alertDistance(const Rcr& particle, const rcr::Twist& v, double dt)
{
	return std::max({ 0.01 * double(particle.capRadius), 2 * dt * plane::speed(v, particle.circumscribedRadius()), particle.foreseen });
}

} // namespace yade

// A body as a step begins: what gathering has found in YADE's objects and later parts of the step need again.
#pragma once

#include <limits>

#include "AlertDistance.hpp"

namespace yade {

struct StepBody {
	Rcr*         particle = nullptr; // its shape, if it is one
	State*       state    = nullptr;
	const Bound* bound    = nullptr;
	bool         free     = false; // a degree of freedom is not blocked
	rcr::Vec2    center;
	rcr::Twist   velocity;
	double       radius   = 0; // circumscribed, of a particle [m]
	double       expected = std::numeric_limits<double>::infinity(); // how far it may go while all that it meets is foreseen [m]

	StepBody() = default;
	StepBody(const Body& b, Rcr* shape, double dt)
	        : particle(shape)
	        , state(b.state.get())
	        , bound(b.bound.get())
	        , free(b.state->blockedDOFs != State::DOF_ALL)
	        , center(plane::toPlane(b.state->pos))
	        , velocity(plane::twist(*b.state))
	        , radius(shape ? shape->circumscribedRadius() : 0)
	{
		if (free) expected = shape ? alertDistance(*shape, velocity, dt) : 2 * dt * plane::speed(velocity, 0);
	}
};

} // namespace yade

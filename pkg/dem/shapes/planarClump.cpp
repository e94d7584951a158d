#include "dem/shapes/planarClump.hpp"

namespace yade {

int planarClump(const boost::python::list& ids, double x, double y, double mass, double inertia)
{
	Scene* scene = Omega::instance().getScene().get();
	auto   body  = boost::make_shared<Body>();
	auto   clump = boost::make_shared<Clump>();
	body->shape  = clump;
	body->setBounded(false);
	const Body::id_t id = scene->bodies->insert(body);
	State&           s  = *body->state;
	for (int k = 0; k < boost::python::len(ids); ++k) {
		const shared_ptr<Body>& member
		        = Body::byId(boost::python::extract<Body::id_t>(ids[k])(), scene);
		if (k == 0) s.pos = Vector3r(x, y, member->state->pos.z());
		Clump::add(body, member);
		Se3r& place       = clump->members[member->getId()];
		place.position    = member->state->pos - s.pos;
		place.orientation = member->state->ori;
	}
	s.refPos      = s.pos;
	s.mass        = mass;
	s.inertia     = Vector3r::Constant(inertia);
	s.blockedDOFs = State::DOF_Z | State::DOF_RX | State::DOF_RY;
	return id;
}

} // namespace yade

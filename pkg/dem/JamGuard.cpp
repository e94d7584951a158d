#include "JamGuard.hpp"

#include <sstream>
#include <stdexcept>

namespace yade {

namespace {

	bool driven(const rcr::InverseMass& inverse, const rcr::Twist& v)
	{
		return (inverse.x == 0 && v.x != 0) || (inverse.y == 0 && v.y != 0) || (inverse.rotation == 0 && v.rotation != 0);
	}

} // namespace

void JamGuard::failed(double overlap, std::size_t point, const rcr::ContactProblem& problem)
{
	grown_ = overlap > crushed && overlap > last_ ? grown_ + 1 : 0;
	last_  = overlap;
	if (grown_ < patience) return;
	std::ostringstream text;
	for (std::size_t id = 0; id < problem.velocity.size(); ++id)
		if (driven(problem.inverseMass[id], problem.freeVelocity[id])) text << (text.tellp() > 0 ? ", #" : "#") << id;
	if (text.tellp() == 0) return; // nothing is driven: loads can be carried, the solver needs more iterations
	const rcr::ContactPoint& c       = problem.points[point];
	const std::string        culprits = text.str();
	text.str("");
	text << "ContactDynamics: jam. Bodies #" << c.body1 << " and #" << c.body2 << " overlap by " << overlap
	     << " of their radii, more with every one of the last " << patience
	     << " steps, and no impulses could stop it. Rigid grains do not give way; the motion prescribed to bodies " << culprits
	     << " asks for it. Stop or reverse that motion (b.state.vel), or press by a force (rcr.mobile_wall, WallStress).";
	forget();
	throw std::runtime_error(text.str());
}

} // namespace yade

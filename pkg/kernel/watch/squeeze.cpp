#include "watch/squeeze.hpp"

namespace rcr {

std::vector<int> drivenBodies(const ContactProblem& problem)
{
	std::vector<int> driven;
	for (std::size_t id = 0; id < problem.inverseMass.size(); ++id) {
		const InverseMass& m = problem.inverseMass[id];
		const Twist&       v = problem.freeVelocity[id];
		if ((m.x == 0 && v.x != 0) || (m.y == 0 && v.y != 0) || (m.rotation == 0 && v.rotation != 0)) driven.push_back(int(id));
	}
	return driven;
}

} // namespace rcr

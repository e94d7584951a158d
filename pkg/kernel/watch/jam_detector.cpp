#include "watch/jam_detector.hpp"

namespace rcr {

std::vector<int> drivenBodies(const ContactProblem& problem)
{
	std::vector<int> driven;
	for (std::size_t id = 0; id < problem.inverseMass.size(); ++id) {
		if (problem.driven(int(id))) driven.push_back(int(id));
	}
	return driven;
}

} // namespace rcr

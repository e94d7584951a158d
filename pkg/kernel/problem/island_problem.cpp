#include "problem/island_problem.hpp"

#include <algorithm>

namespace rcr {

IslandProblem::IslandProblem(const ContactProblem& whole, std::vector<std::int32_t> points,
        std::vector<std::int32_t>& numbers)
        : points_(std::move(points))
{
	problem.points.reserve(points_.size()), problem.impulse.reserve(points_.size());
	for (std::int32_t k : points_)
		for (std::int32_t id : { whole.points[k].body1, whole.points[k].body2 }) {
			if (numbers[id] != unnumbered) continue;
			numbers[id] = 0;
			bodies_.push_back(id);
		}
	std::sort(bodies_.begin(), bodies_.end());
	for (std::int32_t id : bodies_) {
		numbers[id] = std::int32_t(problem.inverseMass.size());
		problem.inverseMass.push_back(whole.inverseMass[id]);
		problem.freeVelocity.push_back(whole.freeVelocity[id]);
		problem.velocity.push_back(whole.velocity[id]);
		if (!whole.yielded.empty()) problem.yielded.push_back(whole.yielded[id]);
	}
	for (std::int32_t k : points_) {
		ContactPoint c = whole.points[k];
		c.body1        = numbers[c.body1];
		c.body2        = numbers[c.body2];
		problem.points.push_back(c);
		problem.impulse.push_back(whole.impulse[k]);
		if (!whole.rollingImpulse.empty())
			problem.rollingImpulse.push_back(whole.rollingImpulse[k]);
		if (!whole.recoveryBias.empty()) problem.recoveryBias.push_back(whole.recoveryBias[k]);
	}
	for (std::int32_t id : bodies_)
		numbers[id] = unnumbered;
}

void IslandProblem::store(ContactProblem& whole) const
{
	for (std::size_t k = 0; k < points_.size(); ++k) {
		whole.impulse[points_[k]] = problem.impulse[k];
		if (!whole.rollingImpulse.empty())
			whole.rollingImpulse[points_[k]] = problem.rollingImpulse[k];
	}
	for (std::size_t k = 0; k < bodies_.size(); ++k) {
		whole.velocity[bodies_[k]] = problem.velocity[k];
		if (!whole.yielded.empty()) whole.yielded[bodies_[k]] = problem.yielded[k];
	}
}

} // namespace rcr

#include "problem/island_problem.hpp"

#include <algorithm>

namespace rcr {

IslandProblem::IslandProblem(const ContactProblem& whole, std::vector<std::int32_t> points)
        : points_(std::move(points))
{
	bodies_.reserve(2 * points_.size());
	problem.points.reserve(points_.size());
	for (std::int32_t k : points_)
		bodies_.insert(bodies_.end(), { whole.points[k].body1, whole.points[k].body2 });
	std::sort(bodies_.begin(), bodies_.end());
	bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
	for (std::int32_t id : bodies_) {
		problem.inverseMass.push_back(whole.inverseMass[id]);
		problem.freeVelocity.push_back(whole.freeVelocity[id]);
		problem.velocity.push_back(whole.velocity[id]);
		if (!whole.yielded.empty()) problem.yielded.push_back(whole.yielded[id]);
	}
	const auto number = [&](std::int32_t id) {
		return std::int32_t(
		        std::lower_bound(bodies_.begin(), bodies_.end(), id) - bodies_.begin());
	};
	for (std::int32_t k : points_) {
		ContactPoint c = whole.points[k];
		c.body1        = number(c.body1);
		c.body2        = number(c.body2);
		problem.points.push_back(c);
		problem.impulse.push_back(whole.impulse[k]);
		if (!whole.rollingImpulse.empty())
			problem.rollingImpulse.push_back(whole.rollingImpulse[k]);
		if (!whole.recoveryBias.empty()) problem.recoveryBias.push_back(whole.recoveryBias[k]);
	}
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

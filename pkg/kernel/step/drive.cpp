#include "step/drive.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace rcr {

namespace {

	constexpr double loads       = 10;   // beside P, of a contact that closes as fast as the drive: its weight closes it by a tenth of that
	constexpr double mostMomenta = 3;    // of a contact that stays rigid …
	constexpr double mostLoads   = 200;  // … and this
	constexpr double stiffest    = 1e-4; // ε that sweeps still solve

	double fastestPrescribed(const ContactProblem& problem)
	{
		double     fastest = 0;
		const auto look    = [&](int body, Vec2 arm) {
			const Twist& v = problem.freeVelocity[body];
			if (problem.prescribed(body)) fastest = std::max(fastest, norm(Vec2 { v.x, v.y } + cross(v.rotation, arm)));
		};
		for (const ContactPoint& c : problem.points) {
			look(c.body1, c.arm1);
			look(c.body2, c.arm2);
			fastest = std::max(fastest, norm(c.drift));
		}
		return fastest;
	}

	/// Bodies that a prescribed motion reaches one through the other, along the longest of all shortest ways over contacts.
	int reachOfDrive(const ContactProblem& problem)
	{
		const std::size_t         count = problem.inverseMass.size();
		std::vector<std::int32_t> first(count + 1), other(2 * problem.points.size()), layer, next;
		for (const ContactPoint& c : problem.points)
			++first[c.body1], ++first[c.body2];
		std::partial_sum(first.begin(), first.end(), first.begin());
		for (const ContactPoint& c : problem.points) {
			other[--first[c.body1]] = c.body2;
			other[--first[c.body2]] = c.body1;
		}
		std::vector<char> seen(count);
		for (std::size_t id = 0; id < count; ++id) {
			const Twist& v = problem.freeVelocity[id];
			seen[id]       = problem.prescribed(id);
			if (seen[id] && (v.x != 0 || v.y != 0 || v.rotation != 0)) layer.push_back(std::int32_t(id));
		}
		int reach = -1;
		for (; !layer.empty(); ++reach) {
			next.clear();
			for (std::int32_t id : layer)
				for (std::int32_t k = first[id]; k < first[id + 1]; ++k) {
					if (!seen[other[k]]) next.push_back(other[k]);
					seen[other[k]] = true;
				}
			layer.swap(next);
		}
		return std::max(reach, 0);
	}

} // namespace

Drive driveOf(const ContactProblem& problem, const std::vector<Twist>& before)
{
	Drive drive;
	drive.speed = fastestPrescribed(problem);
	if (drive.speed == 0 || problem.stretches()) return drive;
	double total = 0, momentum = 0, load = 0;
	int    bodies = 0;
	for (std::size_t id = 0; id < before.size(); ++id) {
		const InverseMass& inverse = problem.inverseMass[id];
		const double       largest = std::max(inverse.x, inverse.y);
		if (largest == 0) continue;
		const Twist&     v    = problem.freeVelocity[id];
		const auto       free = [&](Vec2 u) { return norm(Vec2 { inverse.x > 0 ? u.x : 0, inverse.y > 0 ? u.y : 0 }); };
		++bodies;
		total += 1 / largest;
		momentum += (drive.speed + free({ v.x, v.y })) / largest;
		load += free({ v.x - before[id].x, v.y - before[id].y }) / largest;
	}
	if (bodies == 0) return drive;
	const double rows = bodies / std::max(std::sqrt(bodies), double(reachOfDrive(problem)));
	drive.compliance  = std::max(stiffest, drive.speed * (total / bodies) * rows / (momentum + loads * load));
	drive.mostImpulse = (mostMomenta * momentum + mostLoads * load) / rows;
	return drive;
}

Drive driveOf(const Step& step)
{
	std::vector<Twist> before;
	before.reserve(step.bodies.size());
	for (const StepBody& body : step.bodies)
		before.push_back(body.velocity);
	return driveOf(step.problem, before);
}

} // namespace rcr

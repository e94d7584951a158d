#include "step/drive.hpp"

#include <algorithm>
#include <cmath>

namespace rcr {

namespace {

	constexpr double loads    = 10;   // κ: a contact that closes as fast as the drive bears so many times the loads of a row
	constexpr double most     = 3;    // over p_y, of a contact that stays rigid
	constexpr double stiffest = 1e-4; // ε that sweeps still solve

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

} // namespace

Drive driveOf(const ContactProblem& problem, const std::vector<Twist>& before)
{
	Drive drive;
	drive.speed = fastestPrescribed(problem);
	if (drive.speed == 0) return drive;
	double total = 0, momentum = 0;
	int    bodies = 0;
	for (std::size_t id = 0; id < before.size(); ++id) {
		const InverseMass& inverse = problem.inverseMass[id];
		const double       largest = std::max(inverse.x, inverse.y);
		if (largest == 0) continue;
		const Twist&     v    = problem.freeVelocity[id];
		const auto       free = [&](Vec2 u) { return norm(Vec2 { inverse.x > 0 ? u.x : 0, inverse.y > 0 ? u.y : 0 }); };
		++bodies;
		total += 1 / largest;
		momentum += (drive.speed + free({ v.x, v.y }) + loads * free({ v.x - before[id].x, v.y - before[id].y })) / largest;
	}
	if (bodies == 0) return drive;
	const double row  = momentum / std::sqrt(bodies); // p_y
	drive.compliance  = std::max(stiffest, drive.speed * (total / bodies) / row);
	drive.mostImpulse = most * row;
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

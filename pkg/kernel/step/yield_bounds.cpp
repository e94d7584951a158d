#include "step/yield_bounds.hpp"

#include <array>

#include "parallel/thread_team.hpp"
#include "problem/infeasibility.hpp"
#include "problem/list_by_key.hpp"

namespace rcr {

constexpr double loads       = 10;   // factor of L in the compliance
constexpr double mostMomenta = 3;    // factor of P in the largest rigid impulse
constexpr double mostLoads   = 200;  // factor of L in the largest rigid impulse
constexpr double response    = 0.1;  // w₀ over the response of a body of the mean mass
constexpr double leastLever  = 0.1;  // of a contact of a hinged body, over its radius
constexpr double stiffest    = 1e-4; // smallest ε that sweeps can solve

/// Length of the longest of all shortest chains of contacts that begin at a driven body
/// (breadth-first search).
static int longestChain(const ContactProblem& problem)
{
	const std::size_t         count = problem.inverseMass.size();
	std::vector<std::int32_t> layer, next;
	std::vector<char>         seen(count);
	for (std::size_t id = 0; id < count; ++id) {
		const bool driven = problem.driven(id);
		seen[id]          = driven || problem.prescribed(id);
		if (driven) layer.push_back(std::int32_t(id));
	}
	if (layer.empty()) return 0;
	std::vector<std::array<std::int32_t, 2>> pairs;
	pairs.reserve(problem.points.size());
	for (const ContactPoint& c : problem.points)
		if (pairs.empty() || pairs.back()[0] != c.body1 || pairs.back()[1] != c.body2)
			pairs.push_back({ c.body1, c.body2 });
	std::vector<std::int32_t> first, other;
	listByKey(count, first, other, [&](auto add) {
		for (const auto& [body1, body2] : pairs)
			add(body1, body2), add(body2, body1);
	});
	int length = -1;
	for (; !layer.empty(); ++length) {
		next.clear();
		for (std::int32_t id : layer)
			for (std::int32_t k = first[id]; k < first[id + 1]; ++k) {
				if (!seen[other[k]]) next.push_back(other[k]);
				seen[other[k]] = true;
			}
		layer.swap(next);
	}
	return std::max(length, 0);
}

YieldBounds yieldBoundsOf(const Step& step, ThreadTeam& team)
{
	const ContactProblem& problem = step.problem;
	YieldBounds           bounds;
	int                   chain = 0;
	team.parallelFor(0, 2, [&](int part) {
		if (part == 0) chain = longestChain(problem);
		else
			bounds.driveSpeed = drivenSpeed(problem);
	});
	if (bounds.driveSpeed == 0 || problem.stretches()) return bounds;
	double total = 0, momentum = 0, largestMomentum = 0, load = 0;
	int    bodies = 0;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const InverseMass& inverse    = problem.inverseMass[id];
		const bool         isHinged = !inverse.translates();
		const double       radius = step.bodies[id].radius, lever = leastLever * radius; // if hinged
		// without a radius, no contacts
		if (inverse.prescribed() || (isHinged && lever == 0)) continue;
		const PlanarVector &v = problem.freeVelocity[id], &before = step.bodies[id].velocity;
		const auto   speed = [&](const PlanarVector& u) {
            return isHinged ? lever * std::abs(u.rotation)
			             : norm(Vec2 { inverse.x > 0 ? u.x : 0, inverse.y > 0 ? u.y : 0 })
			                + (inverse.rotation > 0 ? radius * std::abs(u.rotation) : 0);
		};
		const double mass = isHinged ? 1 / (inverse.rotation * lever * lever) : inverse.mass();
		++bodies;
		total += mass;
		const double own = mass * (bounds.driveSpeed + speed(v));
		momentum += own, largestMomentum = std::max(largestMomentum, own);
		load += mass * speed({ v.x - before.x, v.y - before.y, v.rotation - before.rotation });
	}
	if (bodies == 0) return bounds;
	const double rows = bodies / std::max(std::sqrt(bodies), double(chain));
	const double levers = leverAmplification(problem);
	bounds.yielding     = {
		std::max(stiffest, bounds.driveSpeed * (total / bodies) * rows / (momentum + loads * load)),
		response * bodies / total,
		levers * levers * mostMomenta * std::max(momentum / rows, largestMomentum)
		        + mostLoads * load / rows
	};
	return bounds;
}

} // namespace rcr

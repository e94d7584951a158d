#include "problem/infeasibility.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "problem/coulomb.hpp"

namespace rcr {

/// Least response of a wall or a hinged body to an impulse, over that to the best placed one. A
/// smaller direction or lever hardly moves it: its speed would be over ten times that of the point.
constexpr double leastResponse = 0.01;

/// Mass of a body at a point with this arm and response w_nn of the body alone. A wall or a
/// hinged body has the mass that the point meets. Infinite: prescribed or blocked.
static double massAt(const InverseMass& m, Vec2 arm, double response)
{
	if (m.x > 0 && m.y > 0) return m.mass();
	const double most = m.translates() ? std::max(m.x, m.y) : m.rotation * dot(arm, arm);
	return response > 0 ? 1 / std::max(response, leastResponse * most)
	                    : std::numeric_limits<double>::infinity();
}

/// Bounding box of points, also of velocities.
struct Box {
	double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };

	void include(Vec2 v)
	{
		low[0] = std::min(low[0], v.x), high[0] = std::max(high[0], v.x);
		low[1] = std::min(low[1], v.y), high[1] = std::max(high[1], v.y);
	}
	Vec2 size() const { return { std::max(0.0, high[0] - low[0]), std::max(0.0, high[1] - low[1]) }; }
};

/// Shortest and longest lever of the contacts of a hinged body [m].
struct Levers {
	double shortest = INFINITY, longest = 0;

	void include(double lever)
	{
		if (lever <= 0) return;
		shortest = std::min(shortest, lever), longest = std::max(longest, lever);
	}
	double ratio() const { return longest > 0 ? longest / shortest : 1; }
};

double leverAmplification(
        const ContactProblem& problem, const std::vector<LocalVector>& d, double least)
{
	const auto isHinged = [](const InverseMass& m) { return !m.translates() && m.rotation > 0; };
	if (std::none_of(problem.inverseMass.begin(), problem.inverseMass.end(), isHinged)) return 1;
	std::vector<Levers> levers(problem.inverseMass.size()); // of hinged bodies
	const auto          include = [&](int body, Vec2 arm, Vec2 normal) {
        if (isHinged(problem.inverseMass[body]))
			levers[body].include(std::abs(cross(arm, normal)));
	};
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		if (!d.empty() && d[k].n <= least) continue;
		const ContactPoint& c = problem.points[k];
		include(c.body1, c.arm1, c.normal);
		include(c.body2, c.arm2, c.normal);
	}
	double product = 1; // levers in series
	for (const Levers& one : levers)
		product *= one.ratio();
	return product;
}

/// V_s of a direction.
static double velocityScale(const ContactProblem& problem, const std::vector<LocalVector>& d)
{
	double largest = 0, speed2 = 0, opening = 0;
	Box    velocities, places; // of the bodies where d acts
	for (const LocalVector& one : d)
		largest = std::max(largest, one.n);
	const double        none = std::numeric_limits<double>::infinity();
	std::vector<double> mass(problem.inverseMass.size(), none); // where d acts
	const auto          include = [&](int body, Vec2 arm, double response) {
        const InverseMass& m = problem.inverseMass[body];
        mass[body]           = std::min(mass[body], massAt(m, arm, response));
        velocities.include({ problem.freeVelocity[body].x, problem.freeVelocity[body].y });
        places.include(problem.placeOf(body));
	};
	for (std::size_t k = 0; k < d.size(); ++k) {
		if (d[k].n <= noiseShare * largest) continue;
		const ContactPoint& c = problem.points[k];
		const LocalVector   u = freeRelativeVelocity(problem, c);
		// a point that slides at |u_t| opens at µ |u_t|
		speed2 = std::max(speed2, square(u) * std::max(1.0, c.friction * c.friction));
		opening += std::max(0.0, -c.bias);
		include(c.body1, c.arm1, delassus(c, problem.inverseMass[c.body1], {}).nn);
		include(c.body2, c.arm2, delassus(c, {}, problem.inverseMass[c.body2]).nn);
	}
	double total = std::accumulate(mass.begin(), mass.end(), 0.0,
	        [&](double sum, double one) { return one < none ? sum + one : sum; });
	const Vec2 inverse = problem.inverseStretchMass, length = places.size();
	if (inverse.x > 0 && length.x > 0) total += 1 / (inverse.x * length.x * length.x);
	if (inverse.y > 0 && length.y > 0) total += 1 / (inverse.y * length.y * length.y);
	const double speed     = std::max(std::sqrt(speed2), norm(velocities.size()));
	const double amplified = leverAmplification(problem, d, noiseShare * largest);
	return std::sqrt(total) * amplified * (speed + opening);
}

/// The bound of the header over V_s [-], for impulses projected onto their cones. Infinity: no
/// velocities are admissible. 0: this direction gives no bound.
static double velocityChangeBound(
        const ContactProblem& problem, const std::vector<LocalVector>& direction)
{
	std::vector<LocalVector> d(direction.size());
	for (std::size_t k = 0; k < d.size(); ++k)
		d[k] = projectCone(direction[k], problem.points[k].friction);
	std::vector<PlanarVector> change(problem.inverseMass.size()); // M⁻¹Jᵀd
	const Vec2                stretchRate = addImpulses(problem, d, change);
	double                    closing = 0, norm2 = 0; // −d · (u_free + b_n n) and dᵀJ M⁻¹Jᵀd
	for (std::size_t k = 0; k < d.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		closing -= dot(d[k], freeRelativeVelocity(problem, c)) + d[k].n * c.bias;
		// impulses move the image of body 2 by the stretch of the cell
		ContactPoint response = c;
		response.drift        = componentwise(stretchRate, c.shift);
		norm2 += dot(d[k], relativeVelocity(response, change[c.body1], change[c.body2]));
	}
	if (!(closing > 0)) return 0;
	return norm2 > 0 ? closing / (std::sqrt(norm2) * velocityScale(problem, d))
	                 : std::numeric_limits<double>::infinity();
}

double dissipatedEnergy(const ContactProblem& problem)
{
	double energy = 0;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const LocalVector&  p = problem.impulse[k];
		energy -= dot(p, relativeVelocity(problem, c)) + p.n * c.bias;
	}
	return energy;
}

bool exceedsEnergyBound(double energy, double velocityScale)
{
	return 2 * std::sqrt(std::max(energy, 0.0)) > maxChange * velocityScale;
}

bool exceedsChangeBound(const ContactProblem& problem)
{
	return velocityChangeBound(problem, problem.impulse) > maxChange;
}

bool exceedsEnergyBound(const ContactProblem& problem)
{
	return exceedsEnergyBound(dissipatedEnergy(problem), velocityScale(problem, problem.impulse));
}

double boundOfGrowth(const ContactProblem& problem, const std::vector<LocalVector>& before)
{
	std::vector<LocalVector> d(before.size());
	for (std::size_t k = 0; k < d.size(); ++k)
		d[k] = problem.impulse[k] - before[k];
	return velocityChangeBound(problem, d);
}

bool isDivergent(const ContactProblem& problem, const std::vector<LocalVector>& before)
{
	double growth2 = 0, size2 = 0;
	for (std::size_t k = 0; k < before.size(); ++k) {
		growth2 += square(problem.impulse[k] - before[k]);
		size2 += square(problem.impulse[k]);
	}
	return growth2 > divergentGrowth * divergentGrowth * size2
	        && boundOfGrowth(problem, before) > maxChange;
}

bool closesBlocked(
        const ContactProblem& problem, const ContactPoint& c, double roundingVelocity)
{
	const auto translates = [&](int body) { return problem.inverseMass[body].translatesFreely(); };
	return !translates(c.body1) && !translates(c.body2) && delassus(problem, c).nn <= 0
	        && !(problem.prescribed(c.body1) && problem.prescribed(c.body2))
	        && relativeVelocity(problem, c).n + c.bias < -roundingVelocity;
}

} // namespace rcr

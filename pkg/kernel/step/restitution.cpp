#include "step/restitution.hpp"

#include "problem/coulomb.hpp"
#include "problem/disjoint_sets.hpp"

namespace rcr {

namespace {

	constexpr double fullRestitution = 0.99; // share of the restitution that counts as full
	// Impulse over that of an impact of two free bodies; above it, yielded points lose
	// restitution. The excess covers the error of the solver.
	constexpr double freeImpact      = 1.05;

	/// Twice the energies of a collision: growth, loss without restitution, and absolute work of
	/// all points.
	struct Energy {
		double gain = 0, plasticLoss = 0, work = 0;
	};

	/// Adds the energies of a point.
	void add(Energy& of, const Step& step, std::size_t k)
	{
		const ContactPoint& c = step.problem.points[k];
		const LocalVector   p = step.problem.impulse[k];
		const LocalVector   u = step.initialVelocity(c), after = relativeVelocity(step.problem, c);
		of.gain += dot(p, u + after);
		of.work += std::hypot(p.n, p.t) * std::hypot(u.n, u.t);
		// b_n = e u_n⁻
		if (c.bias < 0 && u.n < 0) of.plasticLoss -= p.n * u.n * u.n / (u.n + c.bias);
	}

	Energy sumOf(const Step& step, std::vector<int>::const_iterator begin,
	        std::vector<int>::const_iterator end)
	{
		Energy energy;
		std::for_each(begin, end, [&](int k) { add(energy, step, k); });
		return energy;
	}

	/// Factor of the biases of a pair of bodies or a collision, below 1 if its gain exceeds the
	/// error of the solver.
	double passiveFactor(const Energy& of, double energyTolerance)
	{
		if (of.gain <= energyTolerance * of.work) return 1;
		return of.plasticLoss / (of.plasticLoss + 1.5 * of.gain);
	}

	/// Factor of the bias of a point that is the only one of its bodies.
	double passiveFactorOfPoint(const Step& step, int k)
	{
		const ContactPoint& c = step.problem.points[k];
		return passiveRestitutionFactor(delassus(step.problem, c), step.problem.impulse[k],
		        step.initialVelocity(c), relativeVelocity(step.problem, c), c.bias, c.friction);
	}

	/// Points that bear an impulse in contacts with restitution, grouped by pairs of bodies.
	std::vector<int> pointsByBodies(const Step& step)
	{
		std::vector<int> points;
		for (const StepContact& contact : step.contacts)
			if (contact.law.restitution > 0)
				for (int k = contact.first; k < contact.first + contact.count; ++k)
					if (step.problem.impulse[k].n > 0) points.push_back(k);
		const auto bodies = [&](int k) {
			const ContactPoint& c = step.problem.points[k];
			return std::minmax(c.body1, c.body2);
		};
		const auto before = [&](int a, int b) { return bodies(a) < bodies(b); };
		// the contacts of a step are sorted, so points are too unless clumps own some
		if (!std::is_sorted(points.begin(), points.end(), before))
			std::stable_sort(points.begin(), points.end(), before);
		return points;
	}

} // namespace

bool lowerPairRestitution(Step& step)
{
	bool                   changed = false;
	const std::vector<int> points  = pointsByBodies(step);
	for (auto begin = points.begin(), end = begin; begin != points.end(); begin = end) {
		const ContactPoint& first = step.problem.points[*begin];
		end = std::find_if(begin, points.end(), [&](int k) {
			const ContactPoint& c = step.problem.points[k];
			return std::minmax(c.body1, c.body2) != std::minmax(first.body1, first.body2);
		});
		if (std::none_of(begin, end, [&](int k) { return step.problem.points[k].bias < 0; }))
			continue; // no restitution
		const double share = end - begin == 1 ? passiveFactorOfPoint(step, *begin)
		                                      : passiveFactor(sumOf(step, begin, end), 1e-3);
		if (!(share < 1)) continue;
		changed = true;
		for (auto k = begin; k != end; ++k)
			if (step.problem.points[*k].bias < 0) step.problem.points[*k].bias *= share;
	}
	return changed;
}

bool lowerRestitutionOfYielded(Step& step, bool plastic)
{
	bool lowered = false;
	for (const StepContact& contact : step.contacts) {
		if (!(contact.law.restitution > 0)) continue;
		for (int k = contact.first; k < contact.first + contact.count; ++k) {
			ContactPoint& c = step.problem.points[k];
			if (!step.problem.hasYielded(c.body1) && !step.problem.hasYielded(c.body2)) continue;
			if (!(c.bias < 0)) continue;
			const double before  = step.initialVelocity(c).n;
			const bool   isFull  = c.bias <= fullRestitution * contact.law.restitution * before;
			const double rebound = delassus(step.problem, c).nn * step.problem.impulse[k].n;
			if (isFull && rebound <= freeImpact * (std::abs(before) - c.bias)) continue;
			const double after = relativeVelocity(step.problem, c).n;
			if (after >= -fullRestitution * c.bias) continue;
			c.bias  = after > 0 && !plastic ? -after : std::max(step.gap[k].atStart, 0.0) / step.dt;
			lowered = true;
		}
	}
	if (lowered) step.problem.yielded.assign(step.bodies.size(), false);
	return lowered;
}

void removeNegativeBiases(Step& step)
{
	for (std::size_t k = 0; k < step.gap.size(); ++k) {
		double& bias = step.problem.points[k].bias;
		if (bias < 0) bias = std::max(step.gap[k].atStart, 0.0) / step.dt;
	}
}

bool lowerCollisionRestitution(Step& step, bool plastic, double tolerance)
{
	// energy gain over the work of all impulses that the tolerance of the solver may cause
	const double energyTolerance = tolerance > 0 ? std::clamp(10 * tolerance, 1e-12, 1e-3) : 1e-3;
	ContactProblem& problem = step.problem;
	bool            pushes  = false;
	for (std::size_t k = 0; k < problem.points.size() && !pushes; ++k)
		pushes = problem.points[k].bias < 0 && problem.impulse[k].n > 0;
	if (!pushes) return false;
	// bodies that impulses join; prescribed bodies join none
	DisjointSets        sets(step.bodies.size());
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		if (problem.impulse[k].n > 0 && !problem.prescribed(c.body1)
		        && !problem.prescribed(c.body2))
			sets.join(c.body1, c.body2);
	}
	const auto collisionOf = [&](const ContactPoint& c) {
		return sets.find(problem.prescribed(c.body1) ? c.body2 : c.body1);
	};
	std::vector<Energy> energy(step.bodies.size());
	for (std::size_t k = 0; k < problem.points.size(); ++k)
		if (problem.impulse[k].n > 0) add(energy[collisionOf(problem.points[k])], step, k);
	bool changed = false;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		ContactPoint& c = problem.points[k];
		if (!(c.bias < 0 && problem.impulse[k].n > 0)) continue;
		const double factor = passiveFactor(energy[collisionOf(c)], energyTolerance);
		if (factor == 1) continue;
		c.bias *= plastic ? 0 : factor;
		changed = true;
	}
	return changed;
}

} // namespace rcr

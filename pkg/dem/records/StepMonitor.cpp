#include "dem/records/StepMonitor.hpp"

#include "dem/errors/messages.hpp"
#include "kernel/parallel/thread_team.hpp"
#include "kernel/problem/coulomb.hpp"
#include "kernel/step/energy.hpp"

namespace yade {

// largest strain of a cell per step; beyond it, contacts may stay undetected
constexpr double largestStretch = 0.02;

/// Overlap of a point at the beginning of the step over R₁ + R₂; 0 between two prescribed bodies.
static double overlapOf(const rcr::Step& step, std::size_t k)
{
	const double overlap = rcr::contactSlop * step.gap[k].atStart / step.gap[k].threshold;
	if (overlap <= 0) return 0;
	const rcr::ContactPoint& c = step.problem.points[k];
	return step.problem.prescribed(c.body1) && step.problem.prescribed(c.body2) ? 0 : overlap;
}

static std::string deepestPair(const rcr::Step& step, double overlap)
{
	std::size_t k = 0;
	while (overlapOf(step, k) != overlap)
		++k;
	const rcr::ContactPoint& c = step.problem.points[k];
	return errors::bodyNames({ c.body1, c.body2 });
}

/// Names of the driven bodies and cell; empty: none.
static std::string drivenParts(const rcr::Step& step)
{
	std::vector<Body::id_t> driven;
	for (int id = 0; id < int(step.bodies.size()); ++id)
		if (step.problem.driven(id)) driven.push_back(id);
	std::string parts = errors::bodyNames(driven);
	if (step.cell.driven(step.problem.inverseStretchMass))
		parts += std::string(parts.empty() ? "" : " and ") + "the velocity gradient of the cell";
	return parts;
}

/// `overlaps`: the deepest pair and its overlap. `driven`: parts that squeeze grains.
static std::string squeezeMessage(rcr::JamDetector::Verdict verdict,
        const StepOutcome& outcome, const std::string& overlaps, const std::string& driven)
{
	if (verdict == rcr::JamDetector::Verdict::jam)
		return "jam: " + overlaps
		        + ", and the overlap grows from step to step. These steps have no solution, since "
		          "the motion prescribed to " + driven
		        + " presses rigid grains together. Stop or reverse that motion (b.state.vel, "
		          "O.cell.velGrad), or press by a force (WallStress, CellStress).";
	if (outcome.missed)
		return "not converged: " + overlaps
		        + ", and the overlap grows from step to step. The solver found neither a solution "
		          "in " + std::to_string(outcome.sweeps)
		        + " sweeps nor a proof that none exists, so positions and forces are wrong. Set a "
		          "larger ContactDynamics.maxIterations or a smaller O.dt.";
	return overlaps
	        + ", and the overlap grows, although this step has converged. Positions and forces "
	          "are wrong. The bodies may have passed through each other before: place them "
	          "apart, or take a smaller O.dt from the start.";
}

/// Distance of two parallel walls, of body 2 from body 1 along the axis [m]. `end`: of the step.
static double wallDistance(const rcr::Step& step, const rcr::BodyPair& walls, bool end)
{
	const bool alongX = step.bodies[walls.body1].shape.axis == 0;
	const auto at = [&](int id) {
		const rcr::PlanarVector v = end ? step.velocityToEnd(id) : rcr::PlanarVector {};
		return alongX ? step.bodies[id].center.x + step.dt * v.x
		              : step.bodies[id].center.y + step.dt * v.y;
	};
	return at(walls.body2) - at(walls.body1);
}

/// Throws std::runtime_error if a free wall crosses another one in the step.
static void checkWalls(const rcr::Step& step, long iteration)
{
	for (const rcr::BodyPair& walls : step.wallPairs) {
		const double before = wallDistance(step, walls, false);
		const double after  = wallDistance(step, walls, true);
		// at one place, walls that face each other have the grains between them
		const int sense = step.bodies[walls.body1].shape.sense;
		const bool face = sense != 0 && sense == -step.bodies[walls.body2].shape.sense;
		const double side = before != 0 ? before : face ? sense : 0;
		if (!(side * after < 0)) continue;
		throw std::runtime_error("ContactDynamics: step " + std::to_string(iteration)
		        + " would move " + errors::bodyNames({ walls.body1, walls.body2 })
		        + ", two walls, through each other. Walls have no contacts with each other. Nothing "
		          "has moved. Stop the mobile wall first (b.state.blockedDOFs = 'xyzXYZ', vel = 0), "
		          "or give walls that may cross a Body.mask without a common bit.");
	}
}

std::string StepMonitor::count(
        const rcr::Step& step, const StepOutcome& outcome, rcr::ThreadTeam& team)
{
	checkWalls(step, outcome.iteration);
	largestError = std::max(largestError, outcome.missedError);
	// deepest at the beginning of the step, over R₁ + R₂; not between prescribed bodies
	const double overlap = team.maximum(
	        step.gap.size(), [&](std::size_t k) { return overlapOf(step, k); });
	const auto        verdict = jam.update(overlap, outcome.yielded);
	const bool        none    = verdict == rcr::JamDetector::Verdict::none;
	const std::string driven  = none ? "" : drivenParts(step);
	if (!driven.empty()) {
		const std::string overlaps = deepestPair(step, overlap) + " overlap by "
		        + errors::text(overlap, 2) + " of R₁ + R₂";
		throw std::runtime_error(
		        "ContactDynamics: " + squeezeMessage(verdict, outcome, overlaps, driven));
	}
	const bool intrudes = !step.intruding.none();
	if (!steps.count(outcome.missed, outcome.yielded, overlap, step.overdamped, intrudes))
		return {};
	std::string warning = "step " + std::to_string(outcome.iteration) + ": " + steps.message();
	if (overlap > rcr::StepCounts::reportedOverlap)
		warning += " Deepest in this step: " + deepestPair(step, overlap) + ".";
	if (intrudes)
		warning += " On their paths in this step: "
		        + errors::bodyNames({ step.intruding.body1, step.intruding.body2 }) + ".";
	return warning;
}

void checkFinite(const rcr::Step& step, long iteration)
{
	const auto& velocity = step.problem.velocity;
	const auto  invalid  = std::find_if(velocity.begin(), velocity.end(),
            [](const rcr::PlanarVector& v) { return !rcr::finite(v.x, v.y, v.rotation); });
	if (invalid == velocity.end()) return;
	const gilLock     lock;
	const std::string saved = boost::python::extract<std::string>(
	        boost::python::import("rcr._yade.last_problem").attr("save_not_finite")());
	throw std::runtime_error("ContactDynamics: step " + std::to_string(iteration) + " would give "
	        + errors::bodyNames({ int(invalid - velocity.begin()) }) + " the velocity ("
	        + errors::text(invalid->x) + ", " + errors::text(invalid->y)
	        + ") and the angular velocity " + errors::text(invalid->rotation)
	        + ". Nothing has moved. " + saved);
}

void checkEnergy(const rcr::Step& step, long iteration)
{
	double       kinetic = 0, farthest = 0;
	std::size_t  fastest = 0;
	const auto&  problem = step.problem;
	const auto   twice   = [](const rcr::PlanarVector& v, const rcr::InverseMass& inverse) {
        const auto part = [](double v, double w) { return w > 0 ? v * v / w : 0; };
        return part(v.x, inverse.x) + part(v.y, inverse.y) + part(v.rotation, inverse.rotation);
	};
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const rcr::StepBody& body = step.bodies[id];
		if (problem.driven(int(id))) return;
		const rcr::InverseMass& inverse = problem.inverseMass[id];
		kinetic += 0.5 * (twice(body.velocity, inverse) + twice(problem.freeVelocity[id], inverse));
		if (!body.free || body.radius == 0) continue;
		const double path = step.dt * maxSpeed(body.velocity, body.radius) / body.radius;
		if (path > farthest) farthest = path, fastest = id;
	}
	const rcr::StepEnergy energy = stepEnergy(step, {}, {});
	if (!(-energy.friction - energy.impact > kinetic)) return;
	throw std::runtime_error("ContactDynamics: step " + std::to_string(iteration)
	        + " has not converged, and its contacts would add more kinetic energy than the "
	          "bodies had. Body #"
	        + std::to_string(fastest) + " moves " + errors::text(farthest, 2)
	        + " of its radii in this step. Nothing has moved. Take a smaller O.dt.");
}

void checkCellStress(const rcr::Step& step, long iteration)
{
	if (!step.problem.stretches()) return;
	for (std::size_t k = 0; k < step.problem.points.size(); ++k) {
		const rcr::ContactPoint& c = step.problem.points[k];
		if (delassus(step.problem, c).nn > 0) continue;
		const double gap = step.gap[k].atStart + step.dt * relativeVelocity(step.problem, c).n;
		if (gap < step.gap[k].threshold)
			throw std::runtime_error("ContactDynamics: CellStress presses "
			        + errors::bodyNames({ c.body1, c.body2 })
			        + " against each other, and both have prescribed motion along the normal of "
			          "their contact. Nothing has moved. Let one of them move freely.");
	}
	const rcr::Vec2 m          = step.problem.inverseStretchMass;
	const double    inverse[2] = { m.x, m.y };
	for (int axis = 0; axis < 2; ++axis) {
		const double strain
		        = inverse[axis] > 0 ? std::abs(step.cell.gradient[axis][axis]) * step.dt : 0;
		if (strain > largestStretch)
			throw std::runtime_error("ContactDynamics: CellStress would stretch the cell by "
			        + errors::text(100 * strain) + " % along " + "xy"[axis] + " in step "
			        + std::to_string(iteration)
			        + ", so contacts would stay undetected; expected at most "
			        + errors::text(100 * largestStretch)
			        + " %. Nothing has moved. Set a smaller O.dt or a larger CellStress.mass, or "
			          "compress a loose cell by O.cell.velGrad first.");
	}
}

UnbalancedForce unbalancedForceOf(const rcr::Step& step)
{
	double contact = 0, net = 0, largest = 0; // impulses
	int    closed = 0, free = 0;
	for (const rcr::LocalVector& p : step.problem.impulse) {
		contact += p.n;
		closed += p.n > 0;
	}
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const rcr::StepBody& body = step.bodies[id];
		if (!body.free || !(body.shape.grain() || body.shape.kind == rcr::PlanarShape::none))
			continue;
		const rcr::InverseMass&  inverse = step.problem.inverseMass[id];
		const rcr::PlanarVector &v = step.problem.velocity[id],
		                         before = step.stretched(int(id), step.initialVelocity(int(id)));
		const rcr::Vec2          change { inverse.x > 0 ? (v.x - before.x) / inverse.x : 0,
            inverse.y > 0 ? (v.y - before.y) / inverse.y : 0 };
		largest = std::max(largest, norm(change));
		net += norm(change);
		++free;
	}
	constexpr double none = std::numeric_limits<double>::infinity();
	return { closed > 0 && free > 0 ? (net / free) / (contact / closed) : none,
		closed > 0 ? largest / (contact / closed) : none };
}

} // namespace yade

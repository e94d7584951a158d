#include "dem/loads/CellStress.hpp"

#include "dem/errors/messages.hpp"

namespace yade {

/// Length of the shortest lattice vector along x, or along y (`turned`) [m]; 0: none is there.
static double latticeLength(const rcr::PeriodicCell& cell, bool turned)
{
	constexpr int most   = 4; // edges in this vector
	double        length = 0;
	for (int i = -most; i <= most; ++i)
		for (int j = -most; j <= most; ++j) {
			const rcr::Vec2 v = rcr::product(cell.h, { double(i), double(j) });
			const double    along = turned ? v.y : v.x, across = turned ? v.x : v.y;
			if (along > 0 && std::abs(across) < 1e-9 * along && (length == 0 || along < length))
				length = along;
		}
	return length;
}

/// Lengths of the cell along x and y [m]: the shortest lattice vector along one axis, and the area
/// over it. They do not depend on the choice of the edges, which O.cell.flipCell changes. If
/// prescribed motion has turned all lattice vectors, their ratio is that of the edges.
static rcr::Vec2 lengths(const rcr::PeriodicCell& cell)
{
	const auto& h = cell.h;
	if (h[1][0] == 0 || h[0][1] == 0) return { h[0][0], h[1][1] };
	double x = latticeLength(cell, false);
	if (x == 0) {
		const double y = latticeLength(cell, true);
		const double ratio = std::hypot(h[0][0], h[1][0]) / std::hypot(h[0][1], h[1][1]);
		x                  = y > 0 ? cell.area() / y : std::sqrt(cell.area() * ratio);
	}
	return { x, cell.area() / x };
}

void CellStress::action()
{
	if (!(mass > 0 && math::isfinite(mass)))
		errors::refuse("CellStress.mass = ", errors::text(mass),
		        "; expected a finite factor > 0 of the inertia of the grains.");
	if (math::isinf(stress[0]) || math::isinf(stress[1]))
		errors::refuse("CellStress.stress is infinite; expected a finite stress, or NaN for an "
		                   "axis whose motion is prescribed.");
	for (int axis = 0; axis < 2; ++axis)
		if (stress[axis] < 0)
			errors::refuse("CellStress.stress = (", errors::text(stress[0]), ", ",
			        errors::text(stress[1]),
			        ") would pull the cell apart; expected compressions ≥ 0, or NaN for an axis "
			        "whose motion is prescribed.");
}

void CellStress::clearStressedAxes(Matrix3r& gradient) const
{
	for (int axis = 0; axis < 2; ++axis)
		if (!math::isnan(stress[axis])) gradient(axis, axis) = 0;
}

void CellStress::gatherCell(const NewtonIntegrator& integrator, rcr::Step& step) const
{
	rcr::ContactProblem& problem = step.problem;
	double               grains  = 0; // their mass
	for (const rcr::InverseMass& inverse : problem.inverseMass)
		grains += inverse.mass();
	if (grains == 0) return;
	rcr::PeriodicCell& cell = step.cell;
	const rcr::Vec2    size = lengths(cell);
	const auto         load = [&](int axis, double length, double& inverse, double& rate) {
		if (math::isnan(stress[axis])) return;
		inverse = 12 / (double(mass) * grains * length * length);
		double& g = cell.gradient[axis][axis];
		if (step.overdamped) g = 0;
		rate = -step.dt * (inverse * double(stress[axis]) * cell.area() + g * g);
		g += rate;
	};
	load(0, size.x, problem.inverseStretchMass.x, cell.loadRate.x);
	load(1, size.y, problem.inverseStretchMass.y, cell.loadRate.y);
	if (!problem.stretches()) return;
	if (!step.overdamped && scene->cell->homoDeform < 2)
		errors::refuse("CellStress moves the bodies with the cell, and O.cell.homoDeform = ",
		        scene->cell->homoDeform, "; expected 2, the default.");
	problem.place.resize(step.bodies.size());
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const rcr::StepBody& body = step.bodies[id];
		if (body.owner != int(id)) continue;
		if (integrator.mask > 0) {
			const auto& b = (*scene->bodies)[id];
			if (!b || !b->maskCompatible(integrator.mask)) continue;
		}
		problem.place[id] = body.center;
		if (!step.overdamped) continue; // else prescribed velocities remain
		if (problem.inverseMass[id].x == 0) problem.place[id].x = 0;
		if (problem.inverseMass[id].y == 0) problem.place[id].y = 0;
	}
	problem.addStretch(cell.loadRate, problem.freeVelocity);
}

void suppressHomoDeform(Scene& scene, bool suppress)
{
	const std::string key = "rcr.homoDeform=";
	const auto        tag = std::find_if(scene.tags.begin(), scene.tags.end(),
	               [&](const std::string& t) { return t.compare(0, key.size(), key) == 0; });
	int& present = scene.cell->homoDeform;
	if (suppress && present != 0) {
		if (tag != scene.tags.end()) scene.tags.erase(tag);
		scene.tags.push_back(key + std::to_string(std::exchange(present, 0)));
	} else if (!suppress && tag != scene.tags.end()) {
		if (present == 0) present = std::atoi(tag->c_str() + key.size()); // else a script has set it
		scene.tags.erase(tag);
	}
}

} // namespace yade

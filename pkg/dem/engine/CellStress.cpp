#include "dem/engine/CellStress.hpp"

#include "dem/validation/validation.hpp"

namespace yade {

/// Lengths of the cell along x and y [m]. They do not depend on the choice of its edges, which
/// O.cell.flipCell changes: the shortest lattice vector along x, and the area over it.
static rcr::Vec2 lengths(const rcr::PeriodicCell& cell)
{
	const auto& h = cell.h;
	if (h[1][0] == 0) return { h[0][0], h[1][1] };
	constexpr int most = 4; // edges in this vector
	double        x    = 0;
	for (int i = -most; i <= most; ++i)
		for (int j = -most; j <= most; ++j) {
			const rcr::Vec2 v = rcr::product(h, { double(i), double(j) });
			if (v.x > 0 && std::abs(v.y) < 1e-9 * v.x && (x == 0 || v.x < x)) x = v.x;
		}
	if (x == 0) x = std::sqrt(cell.area()); // prescribed motion has turned all lattice vectors
	return { x, cell.area() / x };
}

void CellStress::action()
{
	if (!(mass > 0 && math::isfinite(mass)))
		validation::refuse("CellStress.mass = ", validation::text(mass),
		        "; expected a finite factor > 0 of the inertia of the grains.");
	if (math::isinf(stress[0]) || math::isinf(stress[1]))
		validation::refuse("CellStress.stress is infinite; expected a finite stress, or NaN for an "
		                   "axis whose motion is prescribed.");
	for (int axis = 0; axis < 2; ++axis)
		if (stress[axis] < 0)
			validation::refuse("CellStress.stress = (", validation::text(stress[0]), ", ",
			        validation::text(stress[1]),
			        ") would pull the cell apart; expected compressions ≥ 0, or NaN for an axis "
			        "whose motion is prescribed.");
}

void CellStress::clearStressedAxes(Matrix3r& gradient) const
{
	for (int axis = 0; axis < 2; ++axis)
		if (!math::isnan(stress[axis])) gradient(axis, axis) = 0;
}

void CellStress::gatherCell(rcr::Step& step) const
{
	double grains = 0; // their mass
	for (const rcr::InverseMass& inverse : step.problem.inverseMass)
		grains += inverse.mass();
	if (grains == 0) return;
	rcr::PeriodicCell& cell = step.cell;
	const rcr::Vec2    size = lengths(cell);
	const auto         load = [&](int axis, double length, double& inverse, double& rate) {
		if (math::isnan(stress[axis])) return;
		inverse = 12 / (double(mass) * grains * length * length);
		if (step.overdamped) cell.gradient[axis][axis] = 0;
		rate = -inverse * step.dt * double(stress[axis]) * cell.area();
		cell.gradient[axis][axis] += rate;
	};
	load(0, size.x, step.problem.inverseStretchMass.x, cell.loadRate.x);
	load(1, size.y, step.problem.inverseStretchMass.y, cell.loadRate.y);
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

#include "dem/engine/CellStress.hpp"

#include "dem/validation/validation.hpp"

namespace yade {

void CellStress::action()
{
	if (!(mass > 0 && math::isfinite(mass)))
		validation::refuse("CellStress.mass = ", validation::text(mass),
		        "; expected a finite factor > 0 of the inertia of the grains.");
	for (int axis = 0; axis < 2; ++axis)
		if (math::isinf(stress[axis]))
			validation::refuse("CellStress.stress is infinite; expected a finite stress, or NaN "
			                   "for an axis whose motion is prescribed.");
	for (int axis = 0; axis < 2; ++axis)
		if (stress[axis] < 0)
			validation::refuse("CellStress.stress = (", validation::text(stress[0]), ", ",
			        validation::text(stress[1]),
			        ") would pull the cell apart; expected compressions ≥ 0, or NaN for an axis "
			        "whose motion is prescribed.");
	if (scene->isPeriodic) scene->cell->homoDeform = 0;
}

void CellStress::clearStressedAxes(Matrix3r& gradient) const
{
	for (int axis = 0; axis < 2; ++axis)
		if (!math::isnan(stress[axis])) gradient(axis, axis) = 0;
}

void CellStress::gatherCell(rcr::Step& step) const
{
	double grains = 0; // their mass
	for (std::size_t id = 0; id < step.bodies.size(); ++id)
		if (step.problem.inverseMass[id].x > 0) grains += 1 / step.problem.inverseMass[id].x;
	if (grains == 0) return;
	rcr::PeriodicCell& cell   = step.cell;
	const double       area   = std::abs(cell.h[0][0] * cell.h[1][1] - cell.h[0][1] * cell.h[1][0]);
	const auto         free   = [&](int axis, double& inverse) {
                if (math::isnan(stress[axis])) return;
                const double size = cell.h[axis][axis];
                inverse           = 12 / (double(mass) * grains * size * size);
                if (step.overdamped) cell.gradient[axis][axis] = 0;
                cell.gradient[axis][axis] -= inverse * step.dt * double(stress[axis]) * area;
	};
	free(0, cell.inverseMass.x);
	free(1, cell.inverseMass.y);
	step.problem.inverseStretchMass = cell.inverseMass;
}

} // namespace yade

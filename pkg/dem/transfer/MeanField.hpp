// Mean velocity field of a periodic cell.
#pragma once

#include "dem/engine/CellStress.hpp"
#include "dem/shapes/plane.hpp"
#include "dem/validation/validation.hpp"

namespace yade {

/// Terms that NewtonIntegrator adds to the velocities of bodies in a cell: change of the mean
/// field, and its convection.
struct MeanField {
	bool     periodic = false;
	Matrix3r gradient = Matrix3r::Zero(), change = Matrix3r::Zero(), convection = Matrix3r::Zero();
	Matrix3r startGradient = Matrix3r::Zero(); // of the flow from which overdamped bodies start

	MeanField(const Scene& scene, const validation::Engines& engines)
	{
		if (!scene.isPeriodic) return;
		const NewtonIntegrator& newton = *engines.integrator;
		const Cell& cell = *scene.cell;
		periodic         = true;
		gradient         = plane::nextGradient(cell);
		if (cell.homoDeform > 0) change = gradient - newton.prevVelGrad;
		if (cell.homoDeform > 1) convection = newton.prevVelGrad;
		startGradient = gradient;
		if (engines.cellStress) engines.cellStress->clearStressedAxes(startGradient);
	}

	rcr::Twist velocityChange(const State& s, double dt) const
	{
		const Vector3r v = change * s.pos + Real(dt) * (convection * s.vel);
		return { double(v[0]), double(v[1]), 0.5 * double(change(1, 0) - change(0, 1)) };
	}
};

} // namespace yade

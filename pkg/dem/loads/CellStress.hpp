// Stresses of a periodic cell under Contact Dynamics. The cell stretches like a body with one
// degree of freedom per axis:
//
//   M_a (g_a⁺ − g_a + g_a² dt) = Σ f_a ℓ_a dt − σ_a V dt
//
// | symbol | unit  | meaning                                                                |
// |--------|-------|------------------------------------------------------------------------|
// | g_a    | 1/s   | stretch rate along axis a, the diagonal of O.cell.velGrad              |
// | f      | N     | force of a contact on its body 2                                       |
// | ℓ      | m     | from the centre of body 1 to that of body 2, or of its image           |
// | σ_a    | Pa    | prescribed stress; compression positive                                |
// | V      | m²    | area of the cell                                                       |
// | M_a    | kg m² | `mass` · Σ m L_a² / 12, inertia of a uniform body against stretching   |
//
// The term g_a² dt lets a cell without forces move on at constant speed. A change of g changes the
// velocity of each body at r by δg ∘ r. The result then does not depend on where the boundary lies,
// nor on the images that hold the bodies. Masses and forces are per unit depth of the plane, as in
// contact_problem.hpp. Impulses and stretching are solved together. A cell that followed the stress
// of the step before would oscillate, since rigid contacts bear any stress. Source: Parrinello and
// Rahman 1981 (motion of the cell); Radjaï and Voivret 2011 (Contact Dynamics).
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/step/step.hpp"

namespace yade {

class CellStress : public GlobalEngine {
public:
	void action() override;
	/// Sets the diagonal entries of a velocity gradient to 0 along axes with a stress.
	void clearStressedAxes(Matrix3r& gradient) const;
	/// Sets inertia and load of the cell of a step, and the bodies that it moves.
	void gatherCell(const NewtonIntegrator&, rcr::Step&) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(CellStress,GlobalEngine,
		"Stresses of the periodic cell under :yref:`ContactDynamics`, per axis. ``O.cell.velGrad`` "
		"follows along these axes and prescribes the motion of the others. All bodies move with the "
		"cell. It must stand before ContactDynamics in ``O.engines``.",
		((Vector2r,stress,Vector2r(0,0),,
			"Stresses along x and y, compression positive [Pa]; NaN: the motion is prescribed."))
		((Real,mass,1,,
			"Inertia of the cell over Σ m L²/12, the sum over its grains [-]; > 0."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(CellStress);

/// Sets O.cell.homoDeform to 0 for steps without inertia, in which NewtonIntegrator must not add
/// the mean flow of the cell; or restores the earlier value, which O.tags keeps, also for another
/// engine and in saved scenes.
void suppressHomoDeform(Scene&, bool suppress);

} // namespace yade

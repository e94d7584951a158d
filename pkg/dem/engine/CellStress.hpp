// Stresses of a periodic cell under Contact Dynamics: the cell stretches as a body of one degree of freedom an axis,
//
//   M_a (g_a⁺ − g_a) = Σ f_a s_a dt − σ_a V dt
//
// | symbol | unit         | meaning                                                                                     |
// |--------|--------------|---------------------------------------------------------------------------------------------|
// | g_a    | 1/s          | rate of stretching along axis a, the diagonal of O.cell.velGrad                              |
// | f, s   | N/m, m       | force of a contact on the image of its body 2 across the boundary, and the shift of that image |
// | σ_a    | N/m          | stress wanted, per unit depth [Pa]; compression positive                                     |
// | V      | m²           | area of the cell                                                                            |
// | M_a    | kg m         | mass · Σ m (L_a²) / 12: `mass` times the inertia of the grains against affine stretching     |
//
// Contact impulses and stretching are solved together: rigid contacts answer without bound to a motion of the cell that they do not allow,
// so a cell that follows the stress of the step before swings, or creeps into the grains.
// Source: Radjaï and Voivret 2011 (periodic boundary conditions of Contact Dynamics).
#pragma once

#include <core/GlobalEngine.hpp>

#include "kernel/step/step.hpp"

namespace yade {

class CellStress : public GlobalEngine {
public:
	void action() override;
	/// Takes what is not prescribed out of a velocity gradient.
	void release(Matrix3r& gradient) const;
	/// Sets mass and load of the cell of a step.
	void load(rcr::Step&) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(CellStress,GlobalEngine,"Presses the periodic cell by constant stresses under :yref:`ContactDynamics`, axis by axis; ``O.cell.velGrad`` then follows. An axis without a stress (NaN), and shear, move as ``O.cell.velGrad`` prescribes. Sets ``O.cell.homoDeform`` to 0: a cell that moves carries grains along by their contacts, as walls do. Stands before ``ContactDynamics`` in ``O.engines``.",
		((Vector2r,stress,Vector2r(0,0),,"Stresses along x and y, compression positive [N/m, per unit depth: Pa]; NaN: the motion is prescribed"))
		((Real,mass,1,,"Inertia of the cell, in units of Σ m L²/12, that of its grains against affine stretching [-]; > 0"))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(CellStress);

} // namespace yade

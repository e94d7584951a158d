// Setting O.cell.homoDeform in steps whose mean flow ContactDynamics applies itself.
#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade {

/// Sets O.cell.homoDeform to 0, since NewtonIntegrator must not add the mean flow of the cell; or
/// restores the earlier value, which O.tags keeps, also for another engine and in saved scenes.
void suppressHomoDeform(Scene&, bool suppress);

} // namespace yade

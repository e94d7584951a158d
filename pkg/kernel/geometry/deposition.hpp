// Layer-by-layer geometric deposition of discs in a box [paper, sec. II B; Bratberg et al. 2002; Voivret et al. 2007].
//
// Each disc goes to the lowest free place of the surface: the lowest centre where it touches two of discs, floor and side
// walls and overlaps nothing. A pore that no disc of a whole layer went into is given up.
#pragma once

#include <vector>

#include "geometry/vec2.hpp"

namespace rcr {

/// Centres [m] of discs that are dropped one after the other into the box 0 ≤ x ≤ width, y ≥ 0.
/// Wants 0 < 2 radius ≤ width of each; the discs do not overlap beyond rounding.
std::vector<Vec2> deposit(const std::vector<double>& radii, double width);

} // namespace rcr

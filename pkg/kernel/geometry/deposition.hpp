// Geometric deposition of discs in a box, layer by layer.
//
// Each disc takes the lowest free position. It touches two discs or walls and overlaps nothing.
// After each layer, places below its lowest disc are closed.
//
// The lowest place is found among pairs of discs. Most pairs lie below other discs and never offer
// a place again. The radii are divided into classes. Each pair lists the classes that may still have
// a free place on it. A disc closes the pair for the radii r to r + Δr if its gap to the place of r
// is below −Δr (1/cos(φ/2) − 1). φ is the angle between the two contacts at this place.
// Source: paper, sec. II B; Bratberg et al. 2002; Voivret et al. 2007.
#pragma once

#include <vector>

#include "geometry/vec2.hpp"

namespace rcr {

/// Centres [m] of discs deposited one by one in the box 0 ≤ x ≤ width, y ≥ 0. Requires
/// 0 < 2 radius ≤ width for each disc. Discs overlap by rounding at most.
std::vector<Vec2> deposit(const std::vector<double>& radii, double width);

} // namespace rcr

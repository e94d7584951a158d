// The error measure of a solution, used by every solver, test and chart.
#pragma once

#include "contact_problem.hpp"

namespace rcr {

/// Natural-map residual of De Saxcé's form of the contact law, relative [-]:
///
///   ‖ p − P_K( p − (u + (b_n + µ|u_t|) n) / w_nn ) ‖ / ‖p‖ ,   K = { |p_t| ≤ µ p_n },
///
/// with u computed anew from `impulse` (not from `velocity`). 0 if and only if the laws hold exactly; +∞ where p = 0 is
/// no solution. Points between two bodies of prescribed motion (w_nn = 0) carry nothing and do not count.
/// Source: De Saxcé and Feng 1998; Acary, Brémond and Huber 2018, §4 (natural map).
double residual(const ContactProblem&);

} // namespace rcr

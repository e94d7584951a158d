// How hard contacts may press where prescribed motion asks for more than rigid grains can do.
//
// A rigid contact bears whatever a drive of the speed V makes of it. In a wedge, and in a step that is next to one, impulses are bounded by
// the geometry alone, and grains are thrown out at many times V; springs would have given way for many steps. The scale of impulses that
// the drive, moving grains and loads account for is
//
//   p_y = Σ m (V + |v_free| + κ |v_free − v⁻|)/√N     over the N free bodies,
//
// what a row of them takes up at the speed of the drive, its own momentum, and κ = 10 times what loads give it in the step. Contacts yield
// (solve_yielding.cpp) such that one of the mean mass m̄ that closes at V bears p_y:
//
//   ε = V m̄/p_y ≤ 1/√N
//
// So loads alone close contacts by a small part of V, whatever the time step. A driven step with a contact beyond 3 p_y yields although it has
// a rigid solution.
//
// | symbol | argument, field | unit | meaning                                      |
// |--------|-----------------|------|----------------------------------------------|
// | v⁻     | before          | m/s  | velocities at the beginning of the step      |
// | V      | speed           | m/s  | the fastest prescribed motion at a contact   |
// | ε      | compliance      | –    | share of its own response by which a contact yields |
// | 3 p_y  | mostImpulse     | N s  | of a contact that stays rigid                |
#pragma once

#include <limits>

#include "step/step.hpp"

namespace rcr {

struct Drive {
	double speed       = 0;    // 0: nothing drives, …
	double compliance  = 0.01; // … and impacts alone can ask for too much
	double mostImpulse = std::numeric_limits<double>::infinity();
};

/// The drive of a problem whose bodies had the velocities `before`.
Drive driveOf(const ContactProblem&, const std::vector<Twist>& before);
Drive driveOf(const Step&);

} // namespace rcr

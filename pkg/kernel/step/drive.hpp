// How hard contacts may press where prescribed motion asks for more than rigid grains can do.
//
// A rigid contact bears whatever a drive of the speed V makes of it. In a wedge, and in a step that is next to one, impulses are bounded by
// the geometry alone, and grains are thrown out at many times V; springs would have given way for many steps. What the drive, moving
// grains and loads account for is, of a row of r of the N free bodies,
//
//   momentum   P = r/N Σ m (V + |v_free|)
//   loads      L = r/N Σ m |v_free − v⁻|
//
// where r = √N, or as many bodies as the drive reaches one through the other over contacts, if these are more: a column that is struck
// at its end is all one row.
//
// Contacts yield (solve_yielding.cpp) such that one of the mean mass m̄ that closes at V bears P + 10 L:
//
//   ε = V m̄/(P + 10 L) ≤ 1/r
//
// So loads alone close contacts by a small part of V, and forces do not depend on the time step. A driven step with a contact beyond
// 3 P + 200 L yields although it has a rigid solution: a row that is struck bears P, and a contact of a sheared packing up to 40 L.
//
// | symbol       | argument, field | unit | meaning                                              |
// |--------------|-----------------|------|------------------------------------------------------|
// | v⁻           | before          | m/s  | velocities at the beginning of the step              |
// | V            | speed           | m/s  | the fastest prescribed motion at a contact           |
// | ε            | compliance      | –    | share of its own response by which a contact yields  |
// | 3 P + 200 L  | yieldImpulse     | N s  | of a contact that stays rigid                        |
//
// Of a cell that stretches under a stress the load is not among these, so that nothing is known of its drive.
#pragma once

#include <limits>

#include "step/step.hpp"

namespace rcr {

struct Drive {
	double speed       = 0;    // 0: nothing drives, …
	double compliance  = 0.01; // … and impacts alone can ask for too much
	double yieldImpulse = std::numeric_limits<double>::infinity();
};

/// The drive of a problem whose bodies had the velocities `before`.
Drive driveOf(const ContactProblem&, const std::vector<Twist>& before, ThreadTeam&);
Drive driveOf(const Step&, ThreadTeam&);

} // namespace rcr

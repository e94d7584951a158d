// Bounds of contact forces in scenes with driven bodies.
//
// A rigid contact bears any impulse that a driven body of speed V causes. In a wedge, only the
// geometry bounds impulses. Grains are ejected at many times V, where springs would have yielded. A
// row of r bodies sets the scale of contact impulses. P and L are r times the means over the N free
// bodies:
//
//   momentum   P = r/N Σ m (V + |v_free|)
//   loads      L = r/N Σ m |v_free − v⁻|
//
// with r = max(√N, contacts in the chain from the drive to the farthest body). The speed |v| of a
// free body is that of its centre plus R |ω|, with the radius R.
//
// In a step without a solution, contacts yield (solve_yielding.cpp). A contact of the mean mass m̄
// that closes at V then bears P + 10 L:
//
//   ε = V m̄/(P + 10 L) ≤ 1/r, at least 1e-4
//
// A contact with w_nn < w₀ = 0.1/m̄ yields as if w_nn = w₀, so it bears at most ten times P + 10 L.
// Under the load L, a contact of the mass m̄ closes more slowly than V/10. A driven island with
// a contact beyond P_y = 3 A² max(P, P₁) + 200 L yields although it has a rigid solution. P₁ is the
// largest m (V + |v_free|) of one body, which a single impact transfers. A is the amplification by
// levers of hinged bodies (problem/infeasibility.hpp). A struck row bears P. A
// contact in a sheared packing bears at most 40 L. A contact that rebounds at the speed −b_n may
// bear 3 |b_n|/w_nn more.
//
// A hinged body can only turn. It counts as the mass I/(0.1 R)² with the speed 0.1 R |ω|, where R is
// its radius: those that a contact at the lever 0.1 R meets.
//
// | symbol | field         | unit | meaning                                                  |
// |--------|---------------|------|----------------------------------------------------------|
// | v⁻     | velocity      | m/s  | velocity at the beginning of the step (StepBody)         |
// | V      | driveSpeed    | m/s  | fastest driven motion at a contact                       |
// | ε      | compliance    | –    | yielding velocity of a contact over its own response     |
// | w₀     | leastResponse | 1/kg | least response w_nn of a yielding contact                |
// | P_y    | yieldImpulse  | N s  | largest impulse of a contact that stays rigid            |
//
// The stress on a stretching cell is unknown here. Such a cell keeps the default ε and an infinite
// P_y.
#pragma once

#include "problem/yielding.hpp"
#include "step/step.hpp"

namespace rcr {

struct YieldBounds {
	double   driveSpeed = 0; // 0: no contact point is driven
	Yielding yielding { 0.01 }; // default ε: for steps without a solution and without driven bodies
};

YieldBounds yieldBoundsOf(const Step&, ThreadTeam&);

} // namespace rcr

// Bodies that pass each other or turn by much within one step.
//
// The law of a step knows each contact by the plane of its beginning: g + dt u_n ≥ 0. The gap in which a solution really ends differs
// from that by the curvature of the way, some s²/2ρ for a relative way s. A disc that flies past a corner is thus deflected by a
// plane that it never meets, and a spinning rod ends inside what it sweeps along. Where the way is long, the gap is measured at the
// moved positions, and its difference to the plane's goes into the bias for the step to be solved once more:
//
//   g_end(v) = g + dt u_n + c  ⟹  b_n = (max(g, 0) + c)/dt
//
// Quasi-static flow never comes here: its ways are a thousandth of a radius a step.
#pragma once

#include <core/Interaction.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>

#include "../kernel/problem/contact_problem.hpp"
#include "CdPhys.hpp"
#include "RcrGeom.hpp"
#include "StepBody.hpp"

namespace yade {

class CurvedWays {
public:
	static constexpr double longWay = 0.01; // relative way in a step over R₁ + R₂ whose curvature, s²/2ρ, may exceed the slop

	CurvedWays();

	/// Has this pair a long way in this step? Told from the bodies alone: nearly no pair has.
	static bool isLong(const StepBody& one, const StepBody& two, const rcr::Twist& v1, const rcr::Twist& v2, double dt)
	{
		const double size = one.radius + two.radius + (one.radius == 0 ? two.radius : two.radius == 0 ? one.radius : 0); // a wall has none
		return dt * (norm(rcr::Vec2 { v2.x - v1.x, v2.y - v1.y }) + std::abs(v1.rotation) * one.radius + std::abs(v2.rotation) * two.radius)
		        > longWay * size;
	}

	/// One such pair of a solved step, whose points are solved.points[first] …; true if a bias has changed, there and in its CdPhys.
	/// Contacts that the way passes are let go only where `letGo` says so: what is let go may sink in.
	bool correct(
	        const Scene&,
	        const InteractionLoop&,
	        const std::vector<StepBody>&,
	        rcr::ContactProblem&       solved,
	        Body::id_t                 id1,
	        Body::id_t                 id2,
	        const RcrGeom&,
	        CdPhys&,
	        int                        first,
	        bool                       letGo);

private:
	rcr::Manifold after(double time, const StepBody&, const StepBody&, const rcr::Twist&, const rcr::Twist&, const Body&, const Body&, IGeomFunctor&);

	shared_ptr<State>       moved1_, moved2_;
	shared_ptr<Interaction> scratch_;
};

} // namespace yade

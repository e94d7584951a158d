// One time step of rigid contacts: all data that its stages read and write, in flat arrays.
//
// pkg/README.md lists the stages. Those between gather and scatter move bodies and contacts in these
// arrays alone, so an error in them moves nothing in the simulation. They call the simulation to
// filter new contacts and to obtain their coefficients. Bodies have the same numbers as in the
// simulation. A contact stores these numbers. A point stores the bodies that its impulse moves, for
// a clump member its clump.
//
// | symbol | field         | unit | meaning                                               |
// |--------|---------------|------|-------------------------------------------------------|
// | ℓ      | alertDistance | m    | distance within which contacts of a body are detected |
// | g      | gap           | m    | gap of a point; negative: overlap                     |
// | b_n    | bias          | m/s  | bias of a point in 0 ≤ u_n + b_n ⟂ p_n ≥ 0            |
// | s      | shift         | m    | from body 2 to its image that meets body 1            |
#pragma once

#include "geometry/planar_shape.hpp"
#include "problem/contact_law.hpp"
#include "problem/contact_problem.hpp"

namespace rcr {

class ThreadTeam;

/// Overlap over R₁ + R₂ that is not corrected. Without it, contacts at rest would open and close
/// endlessly.
constexpr double contactSlop = 1e-4;

/// Creep that a step may leave (problem/residual.hpp): 3e-7 of the mean R₁ + R₂ a step [m/s].
double creepTolerance(const struct Step&);

/// Upper bound of the speed of all points of a body [m/s].
inline double maxSpeed(const PlanarVector& v, double radius)
{
	return norm(Vec2 { v.x, v.y }) + std::abs(v.rotation) * radius;
}

/// Rotation by θ about z as the quaternion (cos θ/2, 0, 0, sin θ/2).
struct Turn {
	double w = 1, z = 0;

	Vec2 axis() const { return { 1 - 2 * z * z, 2 * w * z }; }
};

inline Turn normalized(const Turn& t)
{
	const double length = std::sqrt(t.z * t.z + t.w * t.w);
	return { t.w / length, t.z / length };
}

/// The rotation followed by a rotation by `angle` [rad].
inline Turn turned(const Turn& from, double angle)
{
	const double c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
	return { c * from.w - s * from.z, c * from.z + s * from.w };
}

struct StepBody {
	PlanarShape   shape;
	Vec2          center;
	Turn          turn;
	PlanarVector  velocity;          // at the beginning of the step
	PlanarVector  velocityBefore;    // for impacts: `velocity` without the acceleration of a drive
	Vec2          convection;        // change of the velocity by the flow of a cell [m/s]
	double        radius        = 0; // of the shape; of a clump, distance of its farthest point [m]
	double        alertDistance = 0; // distance within which its contacts were detected [m]
	// longest path that detection covers [m]; infinite for prescribed bodies other than clump
	// members
	double       coveredPath   = std::numeric_limits<double>::infinity();
	std::int32_t owner         = 0;     // body whose motion it shares: itself or its clump
	bool         free          = false; // can move and is no clump member

	Pose pose() const { return { center, turn.axis() }; }
};

/// Pose of a body after `time` [s]. A clump member rotates about the centre of its clump, `owner`.
Pose poseAfter(const StepBody& body, const StepBody& owner, const PlanarVector& velocityOfOwner,
        double time);

/// Velocity of a clump member, from centre and velocity of its clump.
inline PlanarVector memberVelocity(const StepBody& body, Vec2 center, const PlanarVector& v)
{
	const Vec2 round = cross(v.rotation, body.center - center);
	return { v.x + round.x, v.y + round.y, v.rotation };
}

/// Contact of two bodies with the points problem.points[first] … problem.points[first + count − 1].
struct StepContact {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t first = 0, count = 0;
	// index in SceneHandles::sorted, or in Pairs::all for steps in arrays; −1: new
	std::int32_t handleIndex = -1;
	ContactLaw   law;
	double       size = 0; // R₁ + R₂ [m]
	Vec2         shift, drift; // of the image of body 2 [m], and its relative velocity [m/s]

	double slop() const { return contactSlop * size; }
};

/// Gap of a point.
struct Gap {
	double atStart;  // at the beginning of the step [m]
	double threshold;  // −slop [m]; the position correction acts on gaps below it
	bool   loadedBefore; // the point bore a force at the beginning of the step
};

/// Contact of a search (detection/late_contacts.hpp): new, or with other points.
struct FoundContact {
	std::int32_t body1 = 0, body2 = 0;
	Vec2         shift;
	Manifold     manifold;
	bool         known = false; // the step has this contact already
	ContactLaw   law;           // of a new contact; set by the simulation
};

/// Order of contacts and pairs: by body 1, then by body 2.
inline constexpr auto precedes = [](const auto& a, const auto& b) {
	return a.body1 != b.body1 ? a.body1 < b.body1 : a.body2 < b.body2;
};

inline Vec2 product(const double (&m)[2][2], Vec2 v)
{
	return { m[0][0] * v.x + m[0][1] * v.y, m[1][0] * v.x + m[1][1] * v.y };
}

/// Numbers of the base vectors, columns of h, whose sum is nearest to v.
inline Vec2 latticeVector(const double (&h)[2][2], Vec2 v)
{
	const double determinant = h[0][0] * h[1][1] - h[0][1] * h[1][0];
	return { std::round((h[1][1] * v.x - h[0][1] * v.y) / determinant),
		std::round((h[0][0] * v.y - h[1][0] * v.x) / determinant) };
}

/// Homogeneous flow with a velocity gradient [1/s].
struct Flow {
	double gradient[2][2] {};

	PlanarVector at(Vec2 r) const
	{
		const Vec2 v = product(gradient, r);
		return { v.x, v.y, 0.5 * (gradient[1][0] - gradient[0][1]) };
	}
};

/// Periodic cell: base vectors as columns of h [m], and the velocity gradient of its images [1/s].
/// All numbers are zero in an open scene. Before the solve, the gradient has no contribution of
/// contacts.
struct PeriodicCell {
	bool   periodic = false;
	double h[2][2] {}, inverse[2][2] {}, gradient[2][2] {};
	double imageSpeed = 0; // largestDrift when contacts were detected [m/s]
	Vec2   loadRate; // part of the gradient from the load on the cell in this step [1/s]
	// what the cell adds to velocities: the change of its flow, and the flow that convects them
	Flow   change, convection;

	/// Returns true if a prescribed component of its motion is not zero. `inverseMass`: of
	/// stretching along each axis; 0: prescribed.
	bool driven(Vec2 inverseMass) const
	{
		return gradient[0][1] != 0 || gradient[1][0] != 0
		        || (gradient[0][0] != 0 && inverseMass.x == 0)
		        || (gradient[1][1] != 0 && inverseMass.y == 0);
	}

	double area() const { return std::abs(h[0][0] * h[1][1] - h[0][1] * h[1][0]); }
	/// Smaller height of the cell: lower bound of the distance of two images of a body [m].
	double smallestHeight() const
	{
		return area() / std::max(std::hypot(h[0][0], h[1][0]), std::hypot(h[0][1], h[1][1]));
	}
	/// Velocity of an image relative to its body [m/s].
	Vec2 drift(Vec2 shift) const { return product(gradient, shift); }
	/// Largest speed of a neighbouring image relative to its body [m/s].
	double largestDrift() const
	{
		const Vec2 a = drift({ h[0][0], h[1][0] }), b = drift({ h[0][1], h[1][1] });
		return std::max({ norm(a), norm(b), norm(a + b), norm(a - b) });
	}
};

/// Two bodies, or none.
struct BodyPair {
	std::int32_t body1 = -1, body2 = -1;

	bool none() const { return body1 < 0; }
};

struct Step {
	double                    dt         = 0; // [s]
	// bodies start from startFlow; the step removes overlaps completely
	bool                      overdamped = false;
	Flow                      startFlow;
	PeriodicCell              cell;
	std::vector<StepBody>     bodies;
	std::vector<std::int32_t> members;      // clump members
	std::vector<BodyPair>     wallPairs;    // parallel walls of which one is free along its normal
	std::vector<StepContact>  contacts;     // sorted by body1, then body2
	std::vector<Gap>          gap;          // per point
	ContactProblem            problem;
	std::vector<LocalVector>  force;        // per point [N]: start of the solver, then its result
	std::vector<LocalVector>  warmStart;    // impulses from which the last solve began
	std::vector<double>       warmRolling;  // the same of rolling resistance; may be empty
	std::vector<double>       rollingMoment; // per point, on body 2 [N m]
	std::vector<double>       widenedReach; // per body: widened alert distance [m]; 0: none
	// bodies whose reach was widened since contacts were last added; empty before the first solve
	std::vector<std::int32_t> widened;
	std::vector<FoundContact> found, added; // by searches; those that were added
	// per body: position correction and separation [m, rad]; empty: none
	std::vector<PlanarVector> displacement;
	Vec2                      strain;       // of the cell, from the position correction [-]
	BodyPair                  intruding;    // bodies that went too deep into each other on their paths

	/// Point k of a contact as it was detected.
	ManifoldPoint point(const StepContact& c, int k) const
	{
		const ContactPoint& at = problem.points[c.first + k];
		return { bodies[at.body1].center + at.arm1, at.normal, gap[c.first + k].atStart };
	}

	/// Shift of a body to its image nearest to body 1 [m]. A segment may lie beside its centre.
	Vec2 nearestShift(const StepBody& one, const StepBody& two) const
	{
		if (!cell.periodic) return {};
		const Vec2 from2To1 = one.center - two.center + one.shape.offset - two.shape.offset;
		return product(cell.h, latticeVector(cell.h, from2To1));
	}

	/// Velocity of a body without loads and contacts in this step.
	PlanarVector initialVelocity(int id) const
	{
		const Vec2 convection = bodies[bodies[id].owner].convection;
		return bodies[id].velocity + PlanarVector { convection.x, convection.y, 0 };
	}
	/// u of a point without loads and contacts in this step [m/s].
	LocalVector initialVelocity(const ContactPoint& c) const
	{
		return relativeVelocityWithoutStretch(c, problem.stretchRate + cell.loadRate,
		        initialVelocity(c.body1), initialVelocity(c.body2));
	}
	/// u of a point for impacts: initialVelocity, but of driven bodies that of the step before. The
	/// acceleration of a drive is no impact [m/s].
	LocalVector impactVelocity(const ContactPoint& c) const
	{
		const auto of = [&](int id) {
			return initialVelocity(id) + (bodies[id].velocityBefore - bodies[id].velocity);
		};
		return relativeVelocityWithoutStretch(
		        c, problem.stretchRate + cell.loadRate, of(c.body1), of(c.body2));
	}
	/// A velocity of a body plus its change by the stretch of the cell in this step.
	PlanarVector stretched(int id, const PlanarVector& v) const
	{
		const Vec2 place  = problem.placeOf(bodies[id].owner);
		const Vec2 change = componentwise(problem.stretchRate + cell.loadRate, place);
		return v + PlanarVector { change.x, change.y, 0 };
	}

	/// A detected point as a point of the problem. A pull acts if the gap is within the slop or the
	/// range of the pull. Rolling resistance acts at contacts of one point. The bias of the law:
	///
	///   b_n = e u_n⁻  the gap closes within the step and e > 0: Newton's rule with restitution e
	///   b_n = g/dt    open gap, and any gap of an overdamped step
	///   b_n = 0       lasting contact
	ContactPoint contactPoint(const StepContact&, const ManifoldPoint&) const;

	/// Sets the number of contact points and clears the results of the last step.
	void resizePoints(int points);

	/// Sets the points of a contact and the forces from which the solver starts.
	/// `rollingMoment`: of a contact of one point.
	void setPoints(const StepContact&, const Manifold&, const LocalVector* force,
	        double rollingMoment = 0);

	/// p_r of a moment [N s].
	double rollingImpulse(const ContactPoint& c, double moment) const
	{
		return c.rolls() ? dt * (moment / c.rollingLength) : 0;
	}
	const StepContact* find(int body1, int body2) const; // null: no contact
	double roundingVelocity(ThreadTeam&) const; // rounding error of the velocities [m/s]
	void   computePointForces(ThreadTeam&);     // from the impulses

	/// Updates the gradient of the cell and the drifts after a solve. `before`: stretch rate before
	/// it [1/s].
	void updateGradient(Vec2 before);

	/// Upper bound of the path of all points of a body in the step [m]. v is the present velocity
	/// of its centre. A clump member at the distance r from the centre of its clump changes its
	/// velocity by at most |ω| min(|ω| dt, 2) r.
	double pathOf(int id, const PlanarVector& v) const
	{
		const StepBody& body = bodies[id];
		const double    spin = std::abs(v.rotation);
		if (body.owner == id) return dt * maxSpeed(v, body.radius);
		const double arm = norm(body.center - bodies[body.owner].center);
		return dt * (maxSpeed(v, body.radius) + arm * spin * std::min(dt * spin, 2.0));
	}

	/// Velocity that leads to the displaced position at the end of the step.
	PlanarVector velocityToEnd(int id) const
	{
		if (displacement.empty()) return problem.velocity[id];
		const int          owner = bodies[id].owner;
		const PlanarVector v     = problem.velocity[owner] + displacement[owner] / dt;
		return owner == id ? v : memberVelocity(bodies[id], bodies[owner].center, v);
	}

	/// Widens the radius of the clump of a member so that it contains the member.
	void widenClump(int member)
	{
		const StepBody& body = bodies[member];
		if (body.owner == member) return;
		double& radius = bodies[body.owner].radius;
		radius = std::max(radius, norm(body.center - bodies[body.owner].center) + body.radius);
	}

	/// Sets the velocities of clump members after a solve.
	void setMemberVelocities()
	{
		for (std::int32_t id : members) {
			const int owner      = bodies[id].owner;
			problem.velocity[id] = memberVelocity(
			        bodies[id], bodies[owner].center, problem.velocity[owner]);
		}
	}
};

} // namespace rcr

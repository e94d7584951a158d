// One time step of rigid contacts as a value: everything that its stages read and write, in flat arrays.
//
//   gather                bodies, contact points, loads                  from the simulation
//   solve                 impulses                                       problem/solver.hpp
//   missed contacts       that the solved step reaches unforeseen        step/missed_contacts.hpp
//   large displacements   gaps where bodies really end                   step/large_displacements.hpp
//   restitution           lowered where it would give energy             step/restitution.hpp
//   follow stretch        that bodies without inertia make together      step/follow_stretch.hpp
//   position correction   overlaps displaced away                        step/position_correction.hpp
//   scatter               forces, displacements, new contacts            to the simulation
//
// A stage takes the step and leaves it further on; none but the first and the last touches the simulation, so that an error at
// any place leaves that as it was. Bodies keep the numbers that they have in the simulation; a contact knows its bodies by these,
// its points know the bodies whose motion they act on: the same, or their clumps.
//
// | symbol | field         | unit | meaning                                                      |
// |--------|---------------|------|--------------------------------------------------------------|
// | e      | alertDistance | m    | within which contacts of a body are looked for               |
// | g      | gap           | m    | of a point; negative = overlap                               |
// | b_n    | bias          | m/s  | of a point, in 0 ≤ u_n + b_n ⟂ p_n ≥ 0                       |
// | s      | shift         | m    | of body 2 to the image of it that body 1 meets (periodic cell) |
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "geometry/planar_shape.hpp"
#include "problem/contact_problem.hpp"

namespace rcr {

class ThreadTeam;

/// Of R₁ + R₂: overlaps below it are left as they are. Without a slop, contacts at rest would open and close for ever.
constexpr double contactSlop = 1e-4;

inline double speed(const Twist& v, double radius) { return norm(Vec2 { v.x, v.y }) + std::abs(v.rotation) * radius; }

/// A turn about z as the quaternion (cos θ/2, 0, 0, sin θ/2).
struct Turn {
	double w = 1, z = 0;

	Vec2 axis() const { return { 1 - 2 * z * z, 2 * w * z }; }
};

/// Of length 1.
inline Turn scaled(const Turn& t)
{
	const double length = std::sqrt(t.z * t.z + t.w * t.w);
	return { t.w / length, t.z / length };
}

/// Turned further by an angle [rad].
inline Turn turned(const Turn& from, double angle)
{
	const double c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
	return { c * from.w - s * from.z, c * from.z + s * from.w };
}

struct StepBody {
	PlanarShape  shape;
	Vec2         center;
	Turn         turn;
	Twist        velocity;          // at the beginning of the step
	double       radius        = 0; // PlanarShape::radius
	double       alertDistance = 0; // within which its contacts have been looked for [m]
	double       expected      = std::numeric_limits<double>::infinity(); // how far it may go while all that it meets is foreseen [m]
	std::int32_t owner         = 0;     // whose motion it shares: itself, or its clump
	bool         free          = false; // a degree of freedom is not blocked

	Pose pose() const { return { center, turn.axis() }; }
};

/// Where a body stands after the time `time` with a velocity; a clump's member goes round its centre.
Pose moved(const StepBody& body, const StepBody& owner, const Twist& velocityOfOwner, double time);

/// The velocity of a body that shares the motion of its owner.
inline Twist memberVelocity(const StepBody& body, const StepBody& owner, const Twist& v)
{
	const Vec2 round = cross(v.rotation, body.center - owner.center);
	return { v.x + round.x, v.y + round.y, v.rotation };
}

/// One pair of bodies with its points problem.points[first] … problem.points[first + count − 1].
struct StepContact {
	std::int32_t body1 = 0, body2 = 0;
	std::int32_t first = 0, count = 0;
	std::int32_t source      = -1; // number under which the simulation knows it; −1: it does not yet
	double       restitution = 0;
	double       size        = 0; // R₁ + R₂ [m]
	Vec2         shift, drift;    // of the image of body 2, and its velocity relative to body 2

	double slop() const { return contactSlop * size; }
};

/// Gap of a point and the least one that is left as it is [m].
struct Gap {
	double now, allowed;
	bool   carried; // a force when the step began
};

/// A pair that has other points where it is looked at from further off.
struct GrownContact {
	std::int32_t body1 = 0, body2 = 0;
	Vec2         shift;
	Manifold     manifold;
	bool         known    = false; // a contact of the step has other points now
	double       friction = 0, restitution = 0; // of one that is new: the simulation's
};

/// A periodic cell: base vectors as columns, and the gradient of the velocity that its images follow. Without one, all zero. Along an axis
/// with a mass it stretches as stress and contacts drive it; the gradient is that without contacts until a step is solved.
struct PeriodicCell {
	bool   periodic = false;
	double h[2][2] {}, inverse[2][2] {}, gradient[2][2] {};
	Vec2   inverseMass; // of stretching [1/(kg m²)]

	bool stretches() const { return inverseMass.x > 0 || inverseMass.y > 0; }
	/// Is a motion prescribed to it?
	bool driven() const
	{
		return gradient[0][1] != 0 || gradient[1][0] != 0 || (gradient[0][0] != 0 && inverseMass.x == 0) || (gradient[1][1] != 0 && inverseMass.y == 0);
	}

	/// The vector to the image of body 2 that is nearest to body 1, as a shift of body 2.
	Vec2 nearestShift(Vec2 from1To2) const
	{
		if (!periodic) return {};
		const double a = -std::round(inverse[0][0] * from1To2.x + inverse[0][1] * from1To2.y);
		const double b = -std::round(inverse[1][0] * from1To2.x + inverse[1][1] * from1To2.y);
		return { h[0][0] * a + h[0][1] * b, h[1][0] * a + h[1][1] * b };
	}
	/// The velocity of an image relative to its body.
	Vec2 drift(Vec2 shift) const { return { gradient[0][0] * shift.x + gradient[0][1] * shift.y, gradient[1][0] * shift.x + gradient[1][1] * shift.y }; }
};

/// A homogeneous flow: its velocity gradient [1/s].
struct Flow {
	double gradient[2][2] {};

	Twist at(Vec2 r) const
	{
		const auto& g = gradient;
		return { g[0][0] * r.x + g[0][1] * r.y, g[1][0] * r.x + g[1][1] * r.y, 0.5 * (g[1][0] - g[0][1]) };
	}
};

struct Step {
	double                    dt         = 0; // [s]
	bool                      overdamped = false; // every body starts from rest, gaps and overlaps are taken back whole
	Flow                      rest; // what rest is in an overdamped step
	PeriodicCell              cell;
	std::vector<StepBody>     bodies;
	std::vector<std::int32_t> members;  // bodies that share the motion of another
	std::vector<StepContact>  contacts; // sorted by body1, then body2
	std::vector<std::int32_t> firstOf;  // a body: its first contact as body 1, and the end
	std::vector<Gap>          gap;      // a point
	ContactProblem            problem;
	std::vector<Impulse>      force;    // a point: what it carries [N]; starts the solver, and is its result
	std::vector<double>       reach;    // a body: alert distance with which it has looked again [m]; 0: it has not
	std::vector<std::int32_t> lookedAgain; // bodies that did so after the last solve
	std::vector<GrownContact> grown;    // pairs that were seen so with other points, not taken in yet …
	std::vector<GrownContact> taken;    // … and taken in
	std::vector<Twist>        displacement; // a body: what the position correction moves it by [m, rad]; empty: nothing
	Vec2                      strain;       // of the cell, that goes with it [-]

	/// Point k of a contact as it was detected.
	ManifoldPoint point(const StepContact& c, int k) const
	{
		const ContactPoint& at = problem.points[c.first + k];
		return { bodies[at.body1].center + at.arm1, at.normal, gap[c.first + k].now };
	}

	/// A detected point of a contact, as the problem has it; its bias is what the law says at the beginning of the step.
	ContactPoint contactPoint(const StepContact&, const ManifoldPoint&, double friction) const;

	/// Makes room for the points of its contacts, and forgets what the last step has found on its way.
	void begin(int points);

	/// The points of a contact as they were detected, with the forces that they start from.
	void setPoints(const StepContact&, const Manifold&, double friction, const Impulse* force);

	/// contacts → firstOf
	void indexContacts();

	/// The contact of two bodies; null if there is none.
	const StepContact* find(int body1, int body2) const;

	/// What is rounding of velocities that have gone through a step [m/s].
	double rounding(ThreadTeam&) const;

	/// Impulses from forces, and forces from impulses.
	void startFromForces();
	void keepForces(ThreadTeam&);

	/// The gradient of the cell and the drifts of contacts from the stretch that a solve has found.
	void stretchCell(Vec2 before);

	/// Velocities of members, from those of their clumps, after a solve.
	void moveMembers()
	{
		for (std::int32_t id : members)
			problem.velocity[id] = memberVelocity(bodies[id], bodies[bodies[id].owner], problem.velocity[bodies[id].owner]);
	}
};

} // namespace rcr

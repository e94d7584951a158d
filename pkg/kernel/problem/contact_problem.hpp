// The contact problem of one time step: all bodies and contact points, solved together.
//
//   v = v_free + M⁻¹ Jᵀ p             equation of motion over one step
//   u = v₂ + d + ω₂ × r₂ − v₁ − ω₁ × r₁   relative velocity at a point, (n, t) components
//   0 ≤ u_n + b_n  ⟂  p_n ≥ 0         Signorini
//   |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0     Coulomb
//
// A periodic cell may stretch under its contacts, as a body of two more degrees of freedom: its rates of stretching g along x and y change
// by  δg = M_c⁻¹ Σ f ∘ s,  f the impulse of a point and s the shift of the image of its body 2, and d holds δg ∘ s.
//
// | symbol     | field                | unit      | meaning                                        |
// |------------|----------------------|-----------|------------------------------------------------|
// | v, ω       | Twist                | m/s, 1/s  | velocity of a body                             |
// | M⁻¹        | InverseMass          | 1/kg, 1/(kg m²) | 0 = that degree of freedom is prescribed |
// | n          | normal               | –         | unit, from body 1 to body 2; t = n turned by +90° |
// | r₁, r₂     | arm1, arm2           | m         | point minus centre of body 1, of body 2        |
// | b_n        | bias                 | m/s       | gap/dt where open, restitution where it bounces |
// | µ          | friction             | –         | Coulomb coefficient                            |
// | d          | drift                | m/s       | velocity of the image of body 2 that body 1 meets, relative to body 2 (periodic cell) |
// | s          | shift                | m         | from body 2 to that image, where the cell may stretch; else 0 |
// | M_c⁻¹      | inverseStretchMass   | 1/(kg m²) | 0 = the cell's motion is prescribed |
// | δg         | stretch              | 1/s       | change of the rates of stretching that contacts make; out |
// | p          | Impulse              | N s       | on body 2, reaction on body 1; p_n ≥ 0 pushes apart |
//
// Masses, impulses and forces are per unit depth of the plane.
// Source: Moreau 1999 (contact dynamics); Jean 1999; De Saxcé and Feng 1998 (residual.hpp).
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vec2.hpp"

namespace rcr {

class Team;

struct InverseMass {
	double x = 0, y = 0; // 1/m along each axis: a mobile wall is free along one
	double rotation = 0; // 1/I
};

struct Twist {
	double x = 0, y = 0, rotation = 0;
};

/// (n, t) components at a contact point: of an impulse, and of the velocity that goes with it.
struct Impulse {
	double n = 0, t = 0;
};

inline Impulse operator+(Impulse a, Impulse b) { return { a.n + b.n, a.t + b.t }; }
inline Impulse operator-(Impulse a, Impulse b) { return { a.n - b.n, a.t - b.t }; }
inline Impulse operator*(double s, Impulse a) { return { s * a.n, s * a.t }; }
inline double  square(Impulse a) { return a.n * a.n + a.t * a.t; } // |a|²

struct ContactPoint {
	std::int32_t body1 = 0, body2 = 0;
	Vec2         normal;
	Vec2         arm1, arm2;
	double       bias     = 0;
	double       friction = 0;
	Vec2         drift;
	Vec2         shift;

	bool drifts() const { return drift.x != 0 || drift.y != 0 || shift.x != 0 || shift.y != 0; }
	/// d without the stretch δg that it holds.
	Vec2 freeDrift(Vec2 stretch) const { return drift - componentwise(stretch, shift); }
};

struct ContactProblem {
	std::vector<InverseMass>  inverseMass;  // a body
	std::vector<Twist>        freeVelocity; // a body: velocity at the end of the step without contact impulses
	std::vector<ContactPoint> points;       // a contact point; the points of a pair stand side by side
	std::vector<Impulse>      impulse;      // a contact point: warm start in, solution out
	std::vector<Twist>        velocity;     // a body: out, consistent with `impulse`
	std::vector<double>       recovery;     // a contact point: bias ≤ 0 of a step whose contacts yield, by which overlaps are taken back; empty: none
	Vec2                      inverseStretchMass;
	Vec2                      stretch;      // what the points' drifts hold of it

	bool stretches() const { return inverseStretchMass.x > 0 || inverseStretchMass.y > 0; }
	/// Another stretch: the drifts of all points follow.
	void setStretch(Vec2);

	/// No impulse changes the motion of this body.
	bool prescribed(int body) const { return inverseMass[body].x == 0 && inverseMass[body].y == 0 && inverseMass[body].rotation == 0; }

	/// The prescribed components of the motion of a body; free components are zero [m/s, 1/s].
	Twist prescribedMotion(int body) const
	{
		const InverseMass& m = inverseMass[body];
		const Twist&       v = freeVelocity[body];
		return { m.x == 0 ? v.x : 0, m.y == 0 ? v.y : 0, m.rotation == 0 ? v.rotation : 0 };
	}

	/// A driven body has a prescribed component of motion that is not zero, whatever else is free.
	bool driven(int body) const
	{
		const Twist v = prescribedMotion(body);
		return v.x != 0 || v.y != 0 || v.rotation != 0;
	}
};

/// The fastest prescribed motion at any contact point, of bodies and of periodic images [m/s].
double fastestPrescribedMotion(const ContactProblem&);

/// u at a point for the body velocities given, in (n, t).
inline Impulse relativeVelocity(const ContactPoint& c, const Twist& v1, const Twist& v2)
{
	const Vec2 u = Vec2 { v2.x, v2.y } + cross(v2.rotation, c.arm2) - Vec2 { v1.x, v1.y } - cross(v1.rotation, c.arm1) + c.drift;
	return { dot(u, c.normal), dot(u, perp(c.normal)) };
}

/// u at a point at the free velocities of its bodies, without the stretch that contacts cause.
inline Impulse freeRelativeVelocity(const ContactProblem& problem, const ContactPoint& c)
{
	ContactPoint free = c;
	free.drift        = c.freeDrift(problem.stretch);
	return relativeVelocity(free, problem.freeVelocity[c.body1], problem.freeVelocity[c.body2]);
}

/// Adds M⁻¹ Jᵀ p of one point to the velocities of its two bodies.
inline void applyImpulse(const ContactPoint& c, const Impulse& p, const InverseMass& m1, const InverseMass& m2, Twist& v1, Twist& v2)
{
	const Vec2 f = p.n * c.normal + p.t * perp(c.normal);
	v1.x -= m1.x * f.x;
	v1.y -= m1.y * f.y;
	v1.rotation -= m1.rotation * cross(c.arm1, f);
	v2.x += m2.x * f.x;
	v2.y += m2.y * f.y;
	v2.rotation += m2.rotation * cross(c.arm2, f);
}

/// v_free + M⁻¹ Jᵀ p for the impulses of the problem, written to `velocity`; and the stretch, where the cell may.
void updateVelocity(ContactProblem&);

/// Throws std::invalid_argument for arrays of different lengths, an id out of range, a number that is not finite, a
/// negative mass or friction, or a normal that is not of unit length.
void checkProblem(const ContactProblem&, Team&);

} // namespace rcr

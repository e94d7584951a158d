// The contact problem of one time step: all bodies and contact points are solved together.
//
//   v = v_free + M⁻¹ Jᵀ p                                   equation of motion over one step
//   u = v₂ + d + ω₂ × r₂ − v₁ − ω₁ × r₁                     relative velocity, components (n, t)
//   0 ≤ u_n + b_n  ⟂  p_n ≥ 0                               Signorini
//   |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0    Coulomb
//   |p_r| ≤ µ_r p_n, p_r = −µ_r p_n sign(u_r) where u_r ≠ 0  rolling resistance, u_r = ℓ (ω₂ − ω₁)
//
// A pull c > 0 acts between the bodies of a point: p_n + c replaces p_n in the laws, so p_n ≥ −c.
// The moment of rolling resistance on body 2 is ℓ p_r.
//
// A periodic cell that may stretch has two more degrees of freedom, its stretch rates along x and
// y. It moves all bodies alike: v includes δg ∘ r, and d includes δg ∘ s. Contacts change the rates
// by δg = M_c⁻¹ Σ f ∘ (r₂ + s − r₁), with the impulse f of a point in x and y.
//
// | symbol | field              | unit      | meaning                                             |
// |--------|--------------------|-----------|-----------------------------------------------------|
// | v, ω   | PlanarVector       | m/s, 1/s  | velocity of a body                                  |
// | M⁻¹    | InverseMass        | 1/kg, 1/(kg m²) | 0: this degree of freedom is prescribed       |
// | n      | normal             | –         | unit, from body 1 to body 2; t: n rotated by +90°   |
// | r₁, r₂ | arm1, arm2         | m         | point minus centre of body 1, of body 2             |
// | b_n    | bias               | m/s       | gap/dt if open, or velocity of restitution          |
// | µ      | friction           | –         | Coulomb coefficient                                 |
// | c      | pull               | N s       | impulse of adhesion                                 |
// | µ_r    | rollingFriction    | –         | of contacts of one point                            |
// | ℓ      | rollingLength      | m         | R₁ + R₂, or R at an obstacle                        |
// | p_r    | rollingImpulse     | N s       | ℓ p_r: angular impulse on body 2                    |
// | d      | drift              | m/s       | velocity of the periodic image of body 2, relative  |
// | s      | shift              | m         | from body 2 to that image; 0 without CellStress     |
// | r      | place              | m         | of the body that the cell moves; 0: it does not     |
// | M_c⁻¹  | inverseStretchMass | 1/(kg m²) | 0: the motion of the cell is prescribed             |
// | δg     | stretchRate        | 1/s       | out: change of the stretch rates by contacts        |
// | p      | LocalVector        | N s       | on body 2, reaction on body 1; p_n ≥ 0 pushes apart |
//
// Masses, impulses and forces are per unit depth of the plane.
// Source: Moreau 1999 (contact dynamics); Jean 1999; De Saxcé and Feng 1998 (residual.hpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "geometry/vec2.hpp"

namespace rcr {

class ThreadTeam;

struct InverseMass {
	double x = 0, y = 0; // 1/m along each axis; a mobile wall is free along one axis
	double rotation = 0; // 1/I

	/// Returns true if no impulse changes the motion of the body.
	bool prescribed() const { return x == 0 && y == 0 && rotation == 0; }
	/// Returns true if the body can move along an axis. A hinged body can only turn.
	bool translates() const { return x > 0 || y > 0; }
	/// Returns true if the body can move along both axes: no wall, and not hinged.
	bool translatesFreely() const { return x > 0 && y > 0; }
	/// Mass along the axis of the larger inverse mass [kg]; 0: the body does not translate.
	double mass() const { return translates() ? 1 / std::max(x, y) : 0; }
};

/// Components (x, y, rotation) of a velocity, displacement, impulse or force of a body.
struct PlanarVector {
	double x = 0, y = 0, rotation = 0;
};

inline PlanarVector operator+(const PlanarVector& a, const PlanarVector& b)
{
	return { a.x + b.x, a.y + b.y, a.rotation + b.rotation };
}
inline PlanarVector operator-(const PlanarVector& a, const PlanarVector& b)
{
	return { a.x - b.x, a.y - b.y, a.rotation - b.rotation };
}
inline PlanarVector operator*(double s, const PlanarVector& a)
{
	return { s * a.x, s * a.y, s * a.rotation };
}
inline PlanarVector operator/(const PlanarVector& a, double s)
{
	return { a.x / s, a.y / s, a.rotation / s };
}

/// Components (n, t) of an impulse, force or velocity at a contact point.
struct LocalVector {
	double n = 0, t = 0;
};

inline LocalVector operator+(LocalVector a, LocalVector b) { return { a.n + b.n, a.t + b.t }; }
inline LocalVector operator-(LocalVector a, LocalVector b) { return { a.n - b.n, a.t - b.t }; }
inline LocalVector operator*(double s, LocalVector a) { return { s * a.n, s * a.t }; }
inline double      dot(LocalVector a, LocalVector b) { return a.n * b.n + a.t * b.t; }
inline double      square(LocalVector a) { return dot(a, a); }

struct ContactPoint {
	std::int32_t body1 = 0, body2 = 0;
	Vec2         normal;
	Vec2         arm1, arm2;
	double       bias     = 0;
	double       friction = 0;
	Vec2         drift;
	Vec2         shift;
	double       pull = 0, rollingFriction = 0, rollingLength = 0;

	bool rolls() const { return rollingFriction > 0; }

	/// Returns true if body 2 is an image of a cell that moves or may move.
	bool crossesMovingCell() const
	{
		return drift.x != 0 || drift.y != 0 || shift.x != 0 || shift.y != 0;
	}
	/// d without the contribution δg ∘ s of a stretch rate.
	Vec2 freeDrift(Vec2 stretchRate) const { return drift - componentwise(stretchRate, shift); }
};

/// A solution, or an iterate.
struct Impulses {
	std::vector<LocalVector> contact;
	std::vector<double>      rolling; // empty: no point has rolling resistance
};

struct ContactProblem {
	// per body
	std::vector<InverseMass>  inverseMass;
	std::vector<PlanarVector> freeVelocity; // at the end of the step, without contact impulses
	std::vector<PlanarVector> velocity;     // out: consistent with `impulse`
	// in, out: contacts of the body have yielded in this step; may be empty
	std::vector<char>        yielded;

	// per contact point; the points of a pair are adjacent
	std::vector<ContactPoint> points;
	std::vector<LocalVector>  impulse; // in: warm start; out: solution
	std::vector<double>       rollingImpulse; // the same; empty: no point has rolling resistance
	// bias of a yielding contact that removes its overlap, ≤ 0 [m/s]; may be empty
	std::vector<double>       recoveryBias;

	Vec2              inverseStretchMass;
	Vec2              stretchRate; // its change by contacts; velocities and drifts include it
	std::vector<Vec2> place;       // per body; may be empty

	Impulses impulses() const { return { impulse, rollingImpulse }; }
	void     setImpulses(const Impulses& p) { impulse = p.contact, rollingImpulse = p.rolling; }
	void     clearImpulses()
	{
		impulse.assign(points.size(), {});
		rollingImpulse.assign(rollingImpulse.size(), 0);
	}
	/// p_r of a point [N s].
	double rollingImpulseOf(std::size_t point) const
	{
		return rollingImpulse.empty() ? 0 : rollingImpulse[point];
	}
	bool stretches() const { return inverseStretchMass.x > 0 || inverseStretchMass.y > 0; }
	/// r of a body [m].
	Vec2 placeOf(int body) const { return place.empty() ? Vec2 {} : place[body]; }
	/// r₂ + s − r₁ of a point: its relative velocity changes by δg times this [m].
	Vec2 stretchArm(const ContactPoint& c) const
	{
		return c.shift + placeOf(c.body2) - placeOf(c.body1);
	}
	/// Sets the stretch rate and updates the drifts of all points.
	void setStretchRate(Vec2);
	/// A point at another stretch rate of the cell.
	ContactPoint withStretchRate(ContactPoint c, Vec2 rate) const
	{
		c.drift = c.freeDrift(stretchRate) + componentwise(rate, c.shift);
		return c;
	}
	/// Adds δg ∘ r to the velocities of all bodies.
	void addStretch(Vec2 rate, std::vector<PlanarVector>& velocity) const;

	bool prescribed(int body) const { return inverseMass[body].prescribed(); }
	bool hasYielded(int body) const { return !yielded.empty() && yielded[body]; }

	/// Prescribed components of the velocity of a body; free components are 0 [m/s, 1/s].
	PlanarVector prescribedMotion(int body) const
	{
		const InverseMass&  m = inverseMass[body];
		const PlanarVector& v = freeVelocity[body];
		return { m.x == 0 ? v.x : 0, m.y == 0 ? v.y : 0, m.rotation == 0 ? v.rotation : 0 };
	}

	/// Returns true if a prescribed velocity component of the body is not zero.
	bool driven(int body) const
	{
		const PlanarVector v = prescribedMotion(body);
		return v.x != 0 || v.y != 0 || v.rotation != 0;
	}
};

/// Largest speed of driven motion at a contact point, of bodies and of periodic images [m/s].
double drivenSpeed(const ContactProblem&);

/// Returns true if prescribed motions at the contact points differ from one translation of all
/// bodies, which would satisfy the contact laws without impulses.
bool isDriven(const ContactProblem&);

/// u at a point for given velocities of its bodies, components (n, t) [m/s].
inline LocalVector relativeVelocity(
        const ContactPoint& c, const PlanarVector& v1, const PlanarVector& v2)
{
	const Vec2 u = Vec2 { v2.x, v2.y } + cross(v2.rotation, c.arm2) - Vec2 { v1.x, v1.y }
	        - cross(v1.rotation, c.arm1) + c.drift;
	return { dot(u, c.normal), dot(u, perp(c.normal)) };
}

/// u at a point for the velocities of the problem [m/s].
inline LocalVector relativeVelocity(const ContactProblem& problem, const ContactPoint& c)
{
	return relativeVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
}

/// u at a point for these velocities of its bodies, without this stretch rate of the cell [m/s].
inline LocalVector relativeVelocityWithoutStretch(const ContactPoint& c, Vec2 stretchRate,
        const PlanarVector& v1, const PlanarVector& v2)
{
	ContactPoint free = c;
	free.drift        = c.freeDrift(stretchRate);
	return relativeVelocity(free, v1, v2);
}

/// u at a point for the free velocities of its bodies, without the stretch by contacts [m/s].
inline LocalVector freeRelativeVelocity(const ContactProblem& problem, const ContactPoint& c)
{
	return relativeVelocityWithoutStretch(c, problem.stretchRate, problem.freeVelocity[c.body1],
	        problem.freeVelocity[c.body2]);
}

/// u_r at a point for given velocities of its bodies [m/s].
inline double rollingVelocity(
        const ContactPoint& c, const PlanarVector& v1, const PlanarVector& v2)
{
	return c.rollingLength * (v2.rotation - v1.rotation);
}
/// u_r at a point for the velocities of the problem [m/s].
inline double rollingVelocity(const ContactProblem& problem, const ContactPoint& c)
{
	return rollingVelocity(c, problem.velocity[c.body1], problem.velocity[c.body2]);
}

/// Components along x and y of an impulse (n, t) at a point with this normal.
inline Vec2 toCartesian(Vec2 normal, LocalVector p) { return p.n * normal + p.t * perp(normal); }

/// Adds M⁻¹ Jᵀ p of one point to the velocities of its two bodies.
inline void applyImpulse(const ContactPoint& c, const LocalVector& p, const InverseMass& m1,
        const InverseMass& m2, PlanarVector& v1, PlanarVector& v2)
{
	const Vec2 f = toCartesian(c.normal, p);
	v1.x -= m1.x * f.x;
	v1.y -= m1.y * f.y;
	v1.rotation -= m1.rotation * cross(c.arm1, f);
	v2.x += m2.x * f.x;
	v2.y += m2.y * f.y;
	v2.rotation += m2.rotation * cross(c.arm2, f);
}

/// Adds the rolling impulse p_r of one point to the velocities of its two bodies.
inline void applyRollingImpulse(const ContactPoint& c, double p, const InverseMass& m1,
        const InverseMass& m2, PlanarVector& v1, PlanarVector& v2)
{
	const double moment = c.rollingLength * p;
	v1.rotation -= m1.rotation * moment;
	v2.rotation += m2.rotation * moment;
}

/// Adds M⁻¹ Jᵀ p of all points and δg ∘ r to the velocities, without rolling resistance. Returns
/// δg.
Vec2 addImpulses(const ContactProblem&, const std::vector<LocalVector>&,
        std::vector<PlanarVector>& velocity);

/// Writes v_free + M⁻¹ Jᵀ p to `velocity`, and sets the stretch rate if the cell can stretch.
void updateVelocity(ContactProblem&);

/// Sets the velocities of the impulses [m/s]. Returns the stretch rate [1/s].
Vec2 velocitiesOf(const ContactProblem&, std::vector<PlanarVector>& velocity);

/// Throws std::invalid_argument that names the body or point. Rejects arrays of different lengths,
/// ids out of range, numbers that are not finite, negative masses, and friction outside 0 … 1000.
/// Normals must have the length 1.
void checkProblem(const ContactProblem&, ThreadTeam&);

} // namespace rcr

// Errors of a solution, and sums over its contact points. Impulses are per metre of depth, and
// contact_problem.hpp explains the symbols. residual.hpp computes both.
#pragma once

namespace rcr {

struct Errors {
	/// Relative natural-map residual of De Saxcé's form of the contact laws [-]:
	///
	///   ‖p − P_K(p − (u + (b_n + µ|u_t|) n) / w_nn)‖ / ‖p‖,   K = { |p_t| ≤ µ p_n }
	///
	/// The denominator has a lower bound (residualFromSums). The residual is 0 if and only if the
	/// laws hold exactly.
	/// Source: De Saxcé and Feng 1998; Acary, Brémond and Huber 2018, §4 (natural map).
	double residual = 0;

	/// Error as a velocity: RMS of w_nn |p − P_K(…)| over the points, divided by a scale [-].
	/// The scale is the RMS of |u|, at least velocityFloor times the RMS of |u_free|.
	/// It measures closing velocities, and slip where the law requires sticking.
	double kinematicError = 0;
};

/// Sums over contact points, for the errors and for energy bounds.
struct Measures {
	double error2          = 0; // ‖p − P_K(…)‖², the numerator of the residual [(N s)²]
	double impulse2        = 0; // ‖p‖² [(N s)²]
	double normal          = 0; // Σ p_n [N s]
	double kinematicError2 = 0; // Σ w_nn² |p − P_K(…)|² [(m/s)²]
	double velocity2       = 0; // Σ |u|² [(m/s)²]
	double stopping2       = 0; // Σ ((|u_n| + |b_n|)/w_nn)² [(N s)²]
	double dissipated      = 0; // −Σ p · (u + b_n n) [J/m]

	Measures& operator+=(const Measures& other)
	{
		error2 += other.error2, impulse2 += other.impulse2, normal += other.normal;
		kinematicError2 += other.kinematicError2, velocity2 += other.velocity2;
		stopping2 += other.stopping2, dissipated += other.dissipated;
		return *this;
	}
};

} // namespace rcr

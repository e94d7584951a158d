// Sums over the contact points of a solution. Impulses are per metre of depth; contact_problem.hpp
// explains the symbols. d = p − P_K(…) is the error of a point in the contact laws (residual.hpp).
#pragma once

namespace rcr {

struct Measures {
	double error2          = 0; // ‖d‖², the numerator of the residual [(N s)²]
	double impulse2        = 0; // ‖p‖² [(N s)²]
	double normal          = 0; // Σ p_n [N s]
	double kinematicError2 = 0; // Σ w_nn² |d|² [(m/s)²]
	double stopping2       = 0; // Σ ((|u_n| + |b_n|)/w_nn)² [(N s)²]
	double dissipated      = 0; // −Σ p · (u + b_n n) [J/m]
	double rootSpeed       = 0; // Σ √(|u_n| + |u_t|) [√(m/s)]

	// over the points with w_nn ≥ leastResponse only (error_estimate.hpp)
	double errorEnergy   = 0; // Σ w_nn |d|² [J/m]
	double impulseEnergy = 0; // Σ w_nn |p|² [J/m]

	Measures& operator+=(const Measures& other)
	{
		error2 += other.error2, impulse2 += other.impulse2, normal += other.normal;
		kinematicError2 += other.kinematicError2, stopping2 += other.stopping2;
		dissipated += other.dissipated, rootSpeed += other.rootSpeed;
		errorEnergy += other.errorEnergy, impulseEnergy += other.impulseEnergy;
		return *this;
	}
};

} // namespace rcr

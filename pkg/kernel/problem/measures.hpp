// Sums over contact points for the error measures (residual.hpp).
#pragma once

namespace rcr {

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

// Coefficients of a contact: one record from the Ip2 functor to the contact problem.
//
// Step::contactPoint turns them into the law of a point (contact_problem.hpp).
#pragma once

namespace rcr {

struct ContactLaw {
	double friction    = 0; // µ [-]
	double restitution = 0; // e, Newton's coefficient [-]
	double adhesion    = 0; // f_a, pull of a point that touches [N], per unit depth
	double rollingFriction
	        = 0; // µ_r: a contact of one point bears the moment µ_r (R₁ + R₂) f_n [-]
	double adhesionRange = 0; // largest gap at which f_a acts [m]; the slop if that is more
};

} // namespace rcr

#include "contact_problem.hpp"

#include <sstream>
#include <stdexcept>

namespace rcr {

void updateVelocity(ContactProblem& problem)
{
	problem.velocity = problem.freeVelocity;
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		applyImpulse(
		        c,
		        problem.impulse[k],
		        problem.inverseMass[c.body1],
		        problem.inverseMass[c.body2],
		        problem.velocity[c.body1],
		        problem.velocity[c.body2]);
	}
}

void checkProblem(const ContactProblem& problem)
{
	const auto refuse = [](const char* what, std::size_t index, const char* wanted) {
		std::ostringstream message;
		message << what << ' ' << index << ": " << wanted;
		throw std::invalid_argument(message.str());
	};
	const auto sameSize = [](const char* what, std::size_t given, std::size_t wanted) {
		if (given == wanted) return;
		std::ostringstream message;
		message << what << " holds " << given << " entries; wanted " << wanted;
		throw std::invalid_argument(message.str());
	};
	sameSize("freeVelocity", problem.freeVelocity.size(), problem.inverseMass.size());
	sameSize("impulse", problem.impulse.size(), problem.points.size());
	const auto finite = [](std::initializer_list<double> values) {
		for (double value : values)
			if (!std::isfinite(value)) return false;
		return true;
	};
	for (std::size_t i = 0; i < problem.inverseMass.size(); ++i) {
		const InverseMass& m = problem.inverseMass[i];
		const Twist&       v = problem.freeVelocity[i];
		if (!finite({ m.x, m.y, m.rotation, v.x, v.y, v.rotation })) refuse("body", i, "a mass or velocity is not finite");
		if (m.x < 0 || m.y < 0 || m.rotation < 0) refuse("body", i, "an inverse mass is negative; wanted 1/m > 0, or 0 for prescribed motion");
	}
	const int bodies = int(problem.inverseMass.size());
	for (std::size_t k = 0; k < problem.points.size(); ++k) {
		const ContactPoint& c = problem.points[k];
		const Impulse&      p = problem.impulse[k];
		if (c.body1 < 0 || c.body1 >= bodies || c.body2 < 0 || c.body2 >= bodies) refuse("contact point", k, "body id out of range");
		if (c.body1 == c.body2) refuse("contact point", k, "both bodies are the same");
		if (!finite({ c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias, c.friction, p.n, p.t }))
			refuse("contact point", k, "a number is not finite");
		if (std::abs(norm(c.normal) - 1) > 1e-6) refuse("contact point", k, "the normal is not of unit length");
		if (c.friction < 0) refuse("contact point", k, "the friction coefficient is negative; wanted µ ≥ 0");
	}
}

} // namespace rcr

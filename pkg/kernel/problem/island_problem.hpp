// The contact problem of one island.
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

constexpr std::int32_t unnumbered = -1;

class IslandProblem {
public:
	/// Copies the points with these numbers and their bodies, with impulses and velocities.
	/// `numbers`: work space per body of the whole problem, `unnumbered` before and after.
	IslandProblem(const ContactProblem& whole, std::vector<std::int32_t> points,
	        std::vector<std::int32_t>& numbers);

	/// Writes impulses and velocities to the whole problem.
	void store(ContactProblem& whole) const;

	ContactProblem problem;

private:
	std::vector<std::int32_t> bodies_, points_; // their numbers in the whole problem, ascending
};

} // namespace rcr

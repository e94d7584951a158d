// Adhesion: pulls of the contact points as a change of impulses and free velocities.
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

/// While it lives, impulses of the problem contain the pulls, p + c n, and free velocities are
/// those after the pulls. So the contact laws hold without them.
class PullSubstitution {
public:
	explicit PullSubstitution(ContactProblem& problem)
	        : problem_(problem)
	{
		const auto pulls = [](const ContactPoint& c) { return c.pull > 0; };
		if (std::none_of(problem.points.begin(), problem.points.end(), pulls)) return;
		freeVelocity_ = problem.freeVelocity;
		std::vector<LocalVector> pull;
		for (const ContactPoint& c : problem.points)
			pull.push_back({ -c.pull, 0 });
		stretchRate_ = addImpulses(problem, pull, problem.freeVelocity);
		problem.stretchRate = problem.stretchRate - stretchRate_;
		shift(+1);
	}
	PullSubstitution(const PullSubstitution&) = delete;
	~PullSubstitution()
	{
		if (freeVelocity_.empty()) return;
		problem_.freeVelocity = std::move(freeVelocity_);
		problem_.stretchRate  = problem_.stretchRate + stretchRate_;
		shift(-1);
	}

private:
	void shift(double sign)
	{
		for (std::size_t k = 0; k < problem_.points.size(); ++k)
			problem_.impulse[k].n += sign * problem_.points[k].pull;
	}

	ContactProblem&           problem_;
	std::vector<PlanarVector> freeVelocity_; // given; empty: no pull
	Vec2                      stretchRate_;
};

} // namespace rcr

// Contacts that a step reaches although its beginning did not see them.
//
// How far ahead contacts are seen follows from the speeds at the beginning of a step (AlertDistance.hpp). A body that is
// released or hit goes further. Once the step is solved, how far is known: bodies that outrun their alert distance look
// again, and where a gap that the law did not know would close beyond what the position correction leaves, the contact is
// made and the step is to be solved once more.
#pragma once

#include <vector>

#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>

#include "../kernel/problem/contact_problem.hpp"
#include "StepBody.hpp"

namespace yade {

class LateContacts {
public:
	/// Looks for them in a solved step; true if some were made.
	bool find(Scene&, const InteractionLoop&, const std::vector<StepBody>&, const rcr::ContactProblem& solved);
	/// At the end of the step: the next one starts from its own speeds.
	void forget();

private:
	void foresee(const shared_ptr<Body>&, double distance, double dt);
	bool outOfBox(const Body&) const;
	bool wasMissed(const shared_ptr<Interaction>&, Scene&, const InteractionLoop&, const rcr::ContactProblem& solved) const;

	std::vector<shared_ptr<Body>> fast_; // that look further in this step
};

} // namespace yade

// The reductions of a problem: unknowns that the scene does not need are left out. Every problem is looked at anew, and each
// reduction can be switched off. A reduction changes the run time only. Results are bitwise equal where the arithmetic is the same,
// and equal to rounding elsewhere.
#pragma once

#include <string>
#include <vector>

namespace rcr {

struct Reductions {
	bool frictionless = true; // pairs without friction carry one unknown a point, the normal impulse
	bool discs        = true; // where no normal has a lever, an island without friction does not turn, and pairs with friction know no w_nt
	bool fixed        = true; // bodies of prescribed motion have no unknowns: they join no islands and wait for no colour
	bool islands      = true; // parts that do not touch are solved apart, each to its own convergence
	bool layout       = true; // colours and order are kept while the pairs last

	/// The reductions of these names alone. Throws std::invalid_argument for a name that is not known.
	static Reductions of(const std::vector<std::string>& names);
	static const std::vector<std::string>& names();

	bool operator==(const Reductions& o) const
	{
		return frictionless == o.frictionless && discs == o.discs && fixed == o.fixed && islands == o.islands && layout == o.layout;
	}
};

/// The model that a solver made of a problem.
struct ModelSummary {
	int bodies = 0, turning = 0;                // that an impulse can move; of these, with a rotation
	int fixed = 0;                              // of prescribed motion: no unknowns
	int pairs = 0, points = 0;                  // that can carry something
	int frictionalPoints = 0;                   // with two unknowns, others have one
	int islands = 0;
	int layouts = 0;                            // how often colours and order have been made so far

	int unknowns() const { return points + frictionalPoints; }
};

} // namespace rcr

// Reductions of a problem: they leave out unknowns that a scene does not need.
//
// Every problem is examined; each reduction can be switched off. Islands converge separately; other
// reductions change results by rounding only.
#pragma once

#include <string>
#include <vector>

namespace rcr {

struct Reductions {
	bool frictionless = true; // pairs without friction have normal impulses only
	bool discs        = true; // normals through both centres: no w_nt; without friction no rotation
	bool fixed   = true; // prescribed bodies have no unknowns and join neither island nor colour
	bool islands = true; // islands are solved separately, each to its own convergence
	bool layout  = true; // colours and order are kept until the pairs change

	/// Switches on these reductions alone. Throws std::invalid_argument for an unknown name.
	static Reductions                      of(const std::vector<std::string>& names);
	static const std::vector<std::string>& names();

	bool operator==(const Reductions& o) const
	{
		return frictionless == o.frictionless && discs == o.discs && fixed == o.fixed
		        && islands == o.islands && layout == o.layout;
	}
};

/// Size of a problem after reductions.
struct ModelSummary {
	int bodies           = 0; // bodies that impulses can move
	int rotating         = 0; // of these, bodies with a rotation
	int fixed            = 0; // prescribed bodies, without unknowns
	int pairs            = 0; // pairs that can carry an impulse
	int points           = 0; // their contact points
	int frictionalPoints = 0; // points with two unknowns; others have one
	int islands          = 0;
	int layouts          = 0; // number of times that the layout was built

	/// Calls visit(name, value) for the entries of the model in Python.
	template <class Visit> void forEachEntry(Visit visit) const
	{
		visit("bodies", bodies), visit("rotations", rotating), visit("fixed", fixed);
		visit("pairs", pairs), visit("points", points);
		visit("unknowns", points + frictionalPoints);
		visit("frictionless", frictionalPoints == 0);
		visit("islands", islands), visit("layouts", layouts);
	}
};

} // namespace rcr

// Properties of a scene by which YADE's collider excludes pairs of bodies.
//
// The collider checks them only when two boxes begin to overlap. It never lists a pair that a later
// change allows, and after an erasure a new collider registers later bodies only. A change therefore
// restarts the collider.
#pragma once

#include <tuple>
#include <vector>

#include "dem/yadeHeaders.hpp"

namespace yade {

class PairRules {
public:
	/// Returns the bodies whose properties have changed since the last call, or all bodies if the
	/// collider or its mask has. Their contacts of this step may be unlisted; the next run of the
	/// collider lists all pairs.
	std::vector<Body::id_t> update(Scene&, Collider&);

private:
	using Properties = std::tuple<const Body*, mask_t, Body::id_t, bool>; // mask, clump, bounded

	boost::weak_ptr<Factorable> collider_; // a pointer may repeat the address of a deleted one
	mask_t                      avoided_ = 0;
	std::vector<Properties>     bodies_;
};

} // namespace yade

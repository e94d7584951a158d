// Properties of a scene by which YADE's collider excludes pairs of bodies.
//
// The collider checks them only when two boxes begin to overlap. It misses pairs that a later
// change allows. After an erasure, a collider that is new, or that a flip of the cell has cleared,
// registers only bodies that are inserted later. A change therefore restarts the collider.
#pragma once

#include <tuple>
#include <vector>

#include "dem/yadeHeaders.hpp"

namespace yade {

class PairExclusions {
public:
	/// Restarts the collider if properties have changed since the last call. Returns the changed
	/// bodies, or all bodies after a change of the collider, its mask or the kind of cell, or if an
	/// edge has changed by half an edge, as in a flip. The collider may not have listed their
	/// contacts of this step; its next run lists all pairs.
	std::vector<Body::id_t> restartIfChanged(Scene&, Collider&);

	/// Returns true if the last call has found a new body with the id of an erased one.
	bool hasReplaced() const { return hasReplaced_; }

private:
	// A later body may have the address of an erased one.
	using Identity = std::pair<const Body*, long>; // with the step of its insertion
	// identity, mask, clump, bounded
	using Properties = std::tuple<Identity, mask_t, Body::id_t, bool>;

	bool                        hasReplaced_ = false;
	boost::weak_ptr<Factorable> collider_; // a pointer may repeat the address of a deleted one
	mask_t                      avoided_ = 0;
	std::vector<Properties>     bodies_;
	Matrix3r                    edges_ = Matrix3r::Zero(); // of the periodic cell; 0: none
};

} // namespace yade

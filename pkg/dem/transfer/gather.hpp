// First stage of a step: copies YADE's bodies and contacts into the arrays of rcr::Step.
#pragma once

#include "kernel/parallel/thread_team.hpp"
#include "kernel/step/step.hpp"
#include "dem/validation/PairExclusions.hpp"
#include "dem/validation/validation.hpp"
#include "dem/contacts/RcrGeom.hpp"

namespace yade {

/// YADE's objects of a step. Pointers hold until YADE's bodies or interactions change; ArraySteps
/// stops before that.
struct SceneHandles {
	struct Contact {
		RcrGeom*     geom        = nullptr;
		CdPhys*      phys        = nullptr;
		Interaction* interaction = nullptr;
		Body::id_t   id1 = 0, id2 = 0;
		int          points = 0; // 0: not a contact of this law
	};

	std::vector<State*>       state; // per body; null: no body
	std::vector<const Bound*> bound; // per body
	// per body: the collider may not have listed all its contacts of this step
	std::vector<char>         mayLackContacts;
	PairExclusions            pairExclusions; // of the last step
	// by body 1, then body 2; StepContact::handleIndex is the index in this list
	std::vector<Contact>      sorted;
	Real                      z = 0; // height of the plane
};

/// Prescribed bodies that moved in the last step, and their velocities (v_x, v_y, ω).
struct Drives {
	const std::vector<int>&      bodies;
	const std::vector<Vector3r>& velocities;
};

/// Sets bodies, contacts, loads and start forces. Throws std::invalid_argument for unsupported
/// scenes. Erases contacts within clumps; else does not change the scene.
void gather(Scene&, const validation::Engines&, rcr::ThreadTeam&, const Drives& before,
        SceneHandles&, rcr::Step&);

/// Sets the periodic cell of a step and the flow from which overdamped bodies start; before bodies.
void gatherCell(const Scene&, const validation::Engines&, rcr::Step&);

/// Sets inertia and load of the cell; after bodies.
void gatherCellStress(const validation::Engines&, rcr::Step&);

/// Gathers some of the bodies again, with the forces on them. A clump with all its members.
void regatherBodies(Scene&, const validation::Engines&, rcr::ThreadTeam&,
        const std::vector<Body::id_t>&, SceneHandles&, rcr::Step&);

/// Returns true if a grain at this position leaves its box, enlarged by the alert distance of this
/// velocity and the motion of images. The collider may then not list all its contacts. In a
/// periodic cell, boxes are those of unsheared space.
bool grainLeavesBox(const Scene&, const rcr::Step&, const rcr::StepBody&, const Vector3r& at,
        const rcr::PlanarVector&, const Bound&);

/// Returns true if an obstacle at this pose, enlarged by `margin` [m], leaves its box, or if the
/// box does not reach the plane of the grains, at the height z [m].
bool obstacleLeavesBox(const Scene&, const rcr::PlanarShape&, const rcr::Pose&, Real z,
        double margin, const Bound&);

} // namespace yade

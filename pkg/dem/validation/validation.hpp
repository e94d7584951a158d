// Validation of scenes: checks that the laws support a scene (docs/supported.md) and explains
// rejections.
//
// validation.cpp holds the table of rules. Python evaluates it when a run starts. ContactDynamics
// evaluates it when engines, the number of bodies or PairExclusions change. Ig2 functors evaluate
// it for the first new contact after a change of engines, functors or the number of bodies, once
// per thread. ContactDynamics also checks the time step, the integrator and the cell in each step;
// gather checks each body. Each message has the given value, the expected value and a remedy.
#pragma once

#include <functional>

#include "kernel/geometry/planar_shape.hpp"
#include "dem/contacts/CdPhys.hpp"
#include "dem/contacts/sceneRules.hpp"
#include "dem/errors/messages.hpp"

namespace yade {
class CellStress;

/// Interface of ContactDynamics for folders that it includes.
class RigidSolver {
public:
	virtual ~RigidSolver() = default;
	/// Message about the first invalid attribute; empty: none.
	virtual std::string attributeError() const = 0;
};

} // namespace yade

namespace yade::validation {

using namespace errors;

/// The engines of a scene that ContactDynamics needs.
struct Engines {
	NewtonIntegrator*       integrator = nullptr;
	const InteractionLoop*  loop       = nullptr;
	Collider*               collider   = nullptr;
	const CellStress*       cellStress = nullptr;
};

/// Message of the first rule that the scene breaks; empty if it is valid or has no class of rcr.
std::string sceneError(const Scene&);

/// Returns sceneError. Before a run of a valid scene, replaces Bo1 functors of Spheres and restarts
/// the collider if a script has changed PairExclusions. ContactDynamics does so in its steps.
std::string prepareRun(Scene&);

/// Area of the union of grains [m²].
using UnionArea = std::function<double(const std::vector<Body::id_t>&)>;

/// Warnings for suspicious scenes; empty: none. Free bodies whose mass is not that of their area;
/// bodies that overlap by more than 1 % of R₁ + R₂ before their first step; engines of YADE that
/// omit Rcrs; obstacles under springs that turn without being seen by YADE's collider.
std::string massWarning(const Scene&, const UnionArea&);
std::string overlapWarning(const Scene&);
std::string sphereEngineWarning(const Scene&);
std::string turningWarning(const Scene&);

/// Identity of a scene's engines and functors. The pointers are weak, since a new engine may have
/// the address of a deleted one.
struct Signature {
	using Object = boost::weak_ptr<const void>;

	std::size_t         bodies   = 0;
	bool                periodic = false;
	std::vector<Object> objects;

	bool operator==(const Signature&) const;
};

struct SceneQuery;

/// Validates the scene when its engines, their functors or its number of bodies changed.
class Validator {
public:
	Engines validate(const Scene&);       // throws the message of sceneError
	void    recordNextStep(const Scene&); // call it after a step of ContactDynamics
	/// Returns true at the first call for this scene, if earlier calls were for another one.
	bool hasNewScene(const Scene&);
	/// Returns true also within the recorded step: in engines after ContactDynamics.
	bool hasSolved(const Scene& scene) const
	{
		return scene_.lock().get() == &scene
		        && (isNextStep(scene) || scene.iter + 1 == nextStep_);
	}

private:
	/// Returns true if the scene is at the end of the recorded step.
	bool isNextStep(const Scene& scene) const { return scene.iter == nextStep_; }
	void checkLastStep(const SceneQuery&);

	Signature seen_;
	Engines   engines_;
	long      nextStep_ = -1; // expected number and time of the next step
	Real      nextTime_ = 0;
	Matrix3r  gradient_ = Matrix3r::Zero(); // that NewtonIntegrator was to apply

	boost::weak_ptr<const Factorable> scene_;
	bool hasScene_ = false; // not in an engine that has just been made or loaded
};

/// Returns true if YADE's rules of masks, clumps and bounds allow a contact of the two bodies.
bool mayCollide(const Scene&, Collider&, Body::id_t id1, Body::id_t id2);

/// Message about a body of a contact without a FrictMat; empty: both have one.
std::string materialError(const Scene&, Body::id_t id1, Body::id_t id2);

bool isGrain(const Body&);  // an Rcr, a RoundedPolygon or a disc
bool isKinematic(const Engine&); // it prescribes velocities of its `ids`
Real planeOf(const Scene&); // height z of the grains; NaN without grains

/// Message about an invalid position, velocity, mass or blocked degree of freedom of a body; empty:
/// all are valid. The `shape` of a clump is none.
std::string bodyError(const Body&, const rcr::PlanarShape& shape, Real z);

/// Throws that no Ig2 functor handles the pair, unless both bodies are boundaries: fixed bodies,
/// Walls or Facets.
void refuseUnsupported(const Scene&, Body::id_t id1, Body::id_t id2);
/// Throws if friction or restitution of a contact are invalid.
void checkPhys(const CdPhys&, Body::id_t id1, Body::id_t id2);

} // namespace yade::validation

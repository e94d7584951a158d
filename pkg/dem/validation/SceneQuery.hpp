// What the rules of validation ask of a scene: engines by kind and order, law, bodies by shape.
#pragma once

#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "dem/validation/validation.hpp"

namespace yade::validation {

// The law of a scene; mixed: rigid contacts and springs. `any`: rules of scenes with one of these.
enum Law { rigid = 1, springs = 2, mixed = 3, any = rigid | springs, neither = 4 };

template <class Kind> bool isLive(const shared_ptr<Engine>& engine)
{
	return !engine->dead && dynamic_cast<const Kind*>(engine.get());
}

template <class Functor, class List> bool has(const List& functors)
{
	return std::any_of(functors.begin(), functors.end(),
	        [](const auto& f) { return bool(dynamic_cast<const Functor*>(f.get())); });
}

/// A live engine and the live engines that it combines; none of a dead engine.
std::vector<const Engine*> livePartsOf(const Engine&);

/// Returns true for a grain that YADE's engines for spheres leave out.
bool isNoSphere(const Body&);

struct SceneQuery {
	const Scene&                           scene;
	const std::vector<shared_ptr<Engine>>& engines;
	const InteractionLoop*                 loop = nullptr;
	Law                                    law  = neither;

	explicit SceneQuery(const Scene& s) : scene(s), engines(s.engines)
	{
		loop = first<InteractionLoop>();
		const bool solver = indexOf<RigidSolver>() >= 0;
		const bool laws   = loop
		        && has<Law2_RcrGeom_CdPhys_SignoriniCoulomb>(loop->lawDispatcher->functors);
		const bool phys = loop && has<Ip2_FrictMat_FrictMat_CdPhys>(loop->physDispatcher->functors);
		const bool spring = loop
		        && has<Law2_RcrGeom_FrictPhys_CundallStrack>(loop->lawDispatcher->functors);
		if (solver || laws || phys) law = spring ? mixed : rigid;
		else if (spring)
			law = springs;
	}

	template <class Kind> Kind* first() const
	{
		const int at = indexOf<Kind>();
		return at < 0 ? nullptr : dynamic_cast<Kind*>(engines[at].get());
	}
	template <class Kind> int indexOf() const
	{
		const auto found = std::find_if(engines.begin(), engines.end(), isLive<Kind>);
		return found == engines.end() ? -1 : int(found - engines.begin());
	}
	template <class Kind> bool dead() const
	{
		return std::any_of(engines.begin(), engines.end(),
		        [](const auto& e) { return e->dead && dynamic_cast<const Kind*>(e.get()); });
	}
	template <class Shape> const Body* body() const
	{
		for (const auto& b : *scene.bodies)
			if (b && dynamic_cast<const Shape*>(b->shape.get())) return b.get();
		return nullptr;
	}
	bool hasNoSphere() const
	{
		return std::any_of(scene.bodies->begin(), scene.bodies->end(),
		        [](const auto& b) { return b && isNoSphere(*b); });
	}
};

// Rules on engines (engines.cpp). Each returns an error message, or an empty text.
std::string loadAfterSolver(const SceneQuery&);
std::string loadWithoutEffect(const SceneQuery&);
std::string readsTooEarly(const SceneQuery&);
std::string recordersOfMembers(const SceneQuery&);
std::string parallelEngines(const SceneQuery&);
std::string attributeErrors(const SceneQuery&);
std::string timeStep(const SceneQuery&);
std::string finiteMotion(const SceneQuery&);
std::string contactsWithoutBodies(const SceneQuery&);
std::string integrator(const SceneQuery&);
std::string timeStepper(const SceneQuery&);
std::string firstTimeStep(const SceneQuery&);
std::string bounds(const SceneQuery&);
std::string verletDistance(const SceneQuery&);

/// Replaces Bo1_Sphere_Aabb by Bo1_Disc_Aabb in scenes with ContactDynamics, so that discs get
/// the same look-ahead as Rcrs.
void replaceSphereBounds(const Scene&);

// Rules on bodies (bodies.cpp).
std::string invalidBodies(const SceneQuery&);
std::string materials(const SceneQuery&);

// Rules on pairs of shapes (pairs.cpp).
std::string unsupportedPairs(const SceneQuery&);
std::string foreignContacts(const SceneQuery&);
/// Lets YADE look for the functors of all listed pairs anew.
void forgetFunctors(const Scene&);

// Rules on the periodic cell (cell.cpp).
std::string wallsInCell(const SceneQuery&);
std::string cellStress(const SceneQuery&);
std::string velocityGradient(const SceneQuery&);
std::string smallCell(const SceneQuery&);

} // namespace yade::validation

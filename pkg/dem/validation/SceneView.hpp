// View of a scene for the rules of validation: engines by kind and order, law, bodies by shape.
#pragma once

#include "dem/engine/ContactDynamics.hpp"
#include "dem/contacts/Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"
#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"

namespace yade::validation {

// The law of a scene. `any`: rules of scenes with rigid contacts, springs or both.
enum Law { rigid = 1, smooth = 2, both = 3, any = rigid | smooth, neither = 4 };

template <class Kind> bool isLive(const shared_ptr<Engine>& engine)
{
	return !engine->dead && dynamic_cast<const Kind*>(engine.get());
}

template <class Functor, class List> bool has(const List& functors)
{
	return std::any_of(functors.begin(), functors.end(),
	        [](const auto& f) { return bool(dynamic_cast<const Functor*>(f.get())); });
}

struct View {
	const Scene&                           scene;
	const std::vector<shared_ptr<Engine>>& engines;
	const InteractionLoop*                 loop = nullptr;
	Law                                    law  = neither;

	explicit View(const Scene& s) : scene(s), engines(s.engines)
	{
		loop = first<InteractionLoop>();
		const bool solver = indexOf<ContactDynamics>() >= 0;
		const bool laws   = loop
		        && has<Law2_RcrGeom_CdPhys_SignoriniCoulomb>(loop->lawDispatcher->functors);
		const bool phys = loop && has<Ip2_FrictMat_FrictMat_CdPhys>(loop->physDispatcher->functors);
		const bool springs = loop
		        && has<Law2_RcrGeom_FrictPhys_CundallStrack>(loop->lawDispatcher->functors);
		if (solver || laws || phys) law = springs ? both : rigid;
		else if (springs)
			law = smooth;
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
	template <class Kind> int count() const
	{
		return int(std::count_if(engines.begin(), engines.end(), isLive<Kind>));
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
};

// Rules on engines (engines.cpp). Each returns an error message, or an empty text.
std::string loadAfterSolver(const View&);
std::string loadWithoutEffect(const View&);
std::string servoBeforeIntegrator(const View&);
std::string recorderBeforeSolver(const View&);
std::string attributeErrors(const View&);
std::string timeStep(const View&);
std::string finiteMotion(const View&);
std::string contactsWithoutBodies(const View&);
std::string integrator(const View&);
std::string timeStepper(const View&);
std::string firstTimeStep(const View&);
std::string bounds(const View&);

// Rules on bodies (bodies.cpp).
std::string invalidBodies(const View&);
std::string materials(const View&);
std::string obstaclesOutOfPlane(const View&);

// Rules on pairs of shapes (pairs.cpp).
std::string unsupportedPairs(const View&);

// Rules on the periodic cell (cell.cpp).
std::string wallsInCell(const View&);
std::string cellStress(const View&);
std::string velocityGradient(const View&);
std::string smallCell(const View&);

} // namespace yade::validation

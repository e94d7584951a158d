// What is served, by which law, and what is told otherwise: the one place where scenes are accepted or refused.
//
// Served by both laws, in the plane z = const and per unit depth:
//
//   grains     Rcr, Sphere (a disc), and clumps of them
//   obstacles  Wall normal to x or y, Box turned about z, Facet that cuts the plane in a segment; a Box may also be free
//   cell       open, or periodic without walls; rigid: stresses by CellStress
//   material   FrictMat
//   engines    ForceResetter, a collider with a Bo1 for every shape, loads, InteractionLoop with an Ig2_…_RcrGeom for every pair, and
//     rigid    Ip2_FrictMat_FrictMat_CdPhys, Law2_RcrGeom_CdPhys_SignoriniCoulomb; loads and kinematic engines; ContactDynamics; NewtonIntegrator(damping=0)
//     smooth   Ip2_FrictMat_FrictMat_FrictPhys, Law2_RcrGeom_FrictPhys_CundallStrack; NewtonIntegrator
//
// The rules stand in one table in Gate.cpp. They are looked at when a run starts (rcr._session), by ContactDynamics when engines
// or the number of bodies have changed, and by the Ig2 functors when a contact is new; what may change from step to step, numbers of
// bodies and contacts, is looked at where it is gathered. Each refusal says what was found, what is wanted and what to do.
#pragma once

#include <sstream>

#include <core/Interaction.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Scene.hpp>
#include <pkg/dem/NewtonIntegrator.hpp>

#include "../kernel/geometry/planar_shape.hpp"
#include "CdPhys.hpp"

namespace yade {

class CellStress;
class Collider;

namespace gate {

	/// Half the box of a body over the size of a periodic cell, at most: YADE's collider takes boxes of less than half a cell, its margin
	/// (verletDist) included.
	constexpr double largestShare = 0.2;

	/// How much wider along each axis the box of a circle is in the unsheared space of a sheared cell, where YADE's collider works; else 1.
	Vector3r widening(const Scene&);

	/// A number as a user would write it.
	inline std::string text(Real value)
	{
		std::ostringstream out;
		out.precision(12);
		out << value;
		return out.str();
	}

	/// Throws std::invalid_argument with this text.
	[[noreturn]] void refuse(const std::string& message);

	/// The engines that ContactDynamics works with.
	struct Engines {
		const NewtonIntegrator* integrator = nullptr;
		const InteractionLoop*  loop       = nullptr;
		Collider*               collider   = nullptr;
		const CellStress*       cellStress = nullptr;
	};

	/// What of a scene with our classes is refused; empty where nothing is, or where none of our classes is there.
	std::string refusal(const Scene&);

	/// Lets discs of a scene with ContactDynamics be seen as far ahead as Rcrs: a Bo1_Disc_Aabb in the place of a Bo1_Sphere_Aabb.
	void lookAheadOfDiscs(const Scene&);

	/// Lets a collider that has not run yet see the bodies. Once some have been erased, YADE's takes in only those that came or went since the
	/// last run of any collider, so that after `O.engines = […]` nothing would meet.
	void showBodiesToCollider(const Scene&);

	/// What is told where rigid contacts are not solved: no ContactDynamics, or a dead one, in which the gate would live. Empty where one is alive.
	std::string unsolved(const Scene&);

	/// Is a law of ours in the scene?
	bool serves(const Scene&);

	/// What of a scene is served but hardly meant, each empty where nothing is: balls among grains of unit depth; bodies that overlap
	/// before their first step by more than 1 % of R₁ + R₂.
	std::string balls(const Scene&);
	std::string overlaps(const Scene&);

	/// Identity of a scene's engines and functors. Weak pointers, since the address of a deleted engine may be used again.
	struct Signature {
		using Object = boost::weak_ptr<const void>;

		std::size_t         bodies   = 0;
		bool                periodic = false;
		std::vector<Object> objects;

		bool operator==(const Signature&) const;
	};

	/// Looks at the scene when its engines, their functors or its number of bodies have changed.
	class Watch {
	public:
		Engines pass(const Scene&); // throws what `refusal` says
	private:
		Signature seen_;
		Engines   engines_;
	};

	/// Have both bodies a material that knows friction? If not, that is raised in Python as soon as that is possible.
	bool frictional(const Scene&, Body::id_t id1, Body::id_t id2);
	/// May a contact be made of this interaction? If not, the reason is raised in Python as soon as that is possible.
	bool mayTouch(const Interaction&, const Scene&);

	/// Is it an Rcr or a disc?
	bool isGrain(const Body&);

	/// The z of the plane of the grains; NaN where there are none.
	Real planeOf(const Scene&);

	/// Whether the numbers of a body that takes part are in order: finite, in the plane, with a mass where it is free.
	bool fine(const Body&, const rcr::PlanarShape&, Real z);
	/// What is wrong with it; empty where nothing is.
	std::string wrongWith(const Body&, Real z);
	/// The same of the first grain or clump of the scene that has something.
	std::string grainsOf(const Scene&);
	/// Throws it, or tells of forces that are not finite. Forces must be synced.
	[[noreturn]] void refuseBody(const Body&, Scene&, Real z);

	/// A pair that no Ig2 functor serves, of which one could move into the other.
	void checkServed(const Interaction&, const Scene&);

	/// Friction and restitution of a contact.
	void checkPhys(const CdPhys&, Body::id_t id1, Body::id_t id2);

} // namespace gate
} // namespace yade

#include "gather.hpp"

#include <numeric>

#include <core/Clump.hpp>
#include <core/InteractionLoop.hpp>
#include <pkg/common/Collider.hpp>

#include "CellStress.hpp"
#include "Gate.hpp"
#include "boxOfCollider.hpp"
#include "planarShape.hpp"
#include "prefetch.hpp"

namespace yade {

namespace {

	/// The cell as it moves in this step: its images follow the gradient that NewtonIntegrator is going to take.
	rcr::PeriodicCell cellOf(const Scene& scene, const Matrix3r& gradient)
	{
		rcr::PeriodicCell cell;
		if (!scene.isPeriodic) return cell;
		cell.periodic    = true;
		const Matrix3r& h = scene.cell->hSize;
		for (int i = 0; i < 2; ++i)
			for (int j = 0; j < 2; ++j)
				cell.h[i][j] = double(h(i, j)), cell.gradient[i][j] = double(gradient(i, j));
		const double determinant = cell.h[0][0] * cell.h[1][1] - cell.h[0][1] * cell.h[1][0];
		cell.inverse[0][0] = cell.h[1][1] / determinant, cell.inverse[0][1] = -cell.h[0][1] / determinant;
		cell.inverse[1][0] = -cell.h[1][0] / determinant, cell.inverse[1][1] = cell.h[0][0] / determinant;
		return cell;
	}

	/// What NewtonIntegrator adds to the velocities of bodies in a cell, beside forces: the change of the mean field, and its convection.
	struct MeanField {
		bool     periodic = false;
		Matrix3r gradient = Matrix3r::Zero(), change = Matrix3r::Zero(), convection = Matrix3r::Zero();
		Matrix3r rest = Matrix3r::Zero(); // what is prescribed: a body without inertia follows it

		MeanField(const Scene& scene, const gate::Engines& engines)
		{
			if (!scene.isPeriodic) return;
			const NewtonIntegrator& newton = *engines.integrator;
			const Cell& cell = *scene.cell;
			periodic         = true;
			gradient         = cell.velGradChanged || cell.nextVelGrad != Matrix3r::Zero() ? cell.nextVelGrad : cell.velGrad;
			if (cell.homoDeform > 0) change = gradient - newton.prevVelGrad;
			if (cell.homoDeform > 1) convection = newton.prevVelGrad;
			rest = gradient;
			if (engines.cellStress) engines.cellStress->release(rest);
		}

		rcr::Twist added(const State& s, double dt) const
		{
			if (!periodic) return {};
			const Vector3r v = change * s.pos + Real(dt) * (convection * s.vel);
			return { double(v[0]), double(v[1]), 0.5 * double(change(1, 0) - change(0, 1)) };
		}
	};

	class Gatherer {
	public:
		Gatherer(Scene& scene, const gate::Engines& engines, rcr::ThreadTeam& team, StepSources& from, rcr::Step& step)
		        : scene_(scene), newton_(*engines.integrator), team_(team), from_(from), step_(step), field_(scene, engines)
		{
		}

		void bodies();
		void contacts();
		void anew(Body::id_t);

	private:
		void                 body(const Body&);
		void                 foresee(const Body&, const rcr::Twist& velocity, rcr::StepBody&);
		void                 move(const Body&, const State&, rcr::StepBody&);
		std::pair<Vector3r, Vector3r> load(const Body&) const;
		StepSources::Contact contactOf(Interaction&) const;
		void                 sort();
		void                 points(std::size_t number);

		Scene&                  scene_;
		const NewtonIntegrator& newton_;
		rcr::ThreadTeam&              team_;
		StepSources&            from_;
		rcr::Step&              step_;
		MeanField               field_;
	};

	void Gatherer::bodies()
	{
		const BodyContainer& bodies = *scene_.bodies;
		const std::size_t    count  = bodies.size();
		step_.dt                    = double(scene_.dt);
		step_.cell                  = cellOf(scene_, field_.gradient);
		if (field_.periodic) step_.rest = plane::flowOf(field_.rest);
		step_.problem.inverseMass.resize(count);
		step_.problem.freeVelocity.resize(count);
		step_.bodies.resize(count);
		from_.state.resize(count);
		from_.bound.resize(count);
		from_.z = gate::planeOf(scene_);
		team_.forEach(count, [&](Body::id_t id) {
			if (id + 2 * prefetchAhead < count) {
				prefetch<Body>(bodies[id + 2 * prefetchAhead].get());
				prefetchBody(bodies[id + prefetchAhead].get());
			}
			anew(id);
		});
		step_.members.clear();
		for (std::size_t id = 0; id < count; ++id) {
			const int owner = step_.bodies[id].owner;
			if (owner == int(id)) continue;
			step_.members.push_back(int(id));
			const double reach = norm(step_.bodies[id].center - step_.bodies[owner].center) + step_.bodies[id].radius;
			step_.bodies[owner].radius = std::max(step_.bodies[owner].radius, reach);
		}
	}

	void Gatherer::anew(Body::id_t id)
	{
		step_.problem.inverseMass[id]  = {};
		step_.problem.freeVelocity[id] = {};
		step_.bodies[id]               = {};
		step_.bodies[id].owner         = id;
		from_.state[id]                = nullptr;
		from_.bound[id]                = nullptr;
		if (const Body* b = (*scene_.bodies)[id].get()) body(*b);
	}

	void Gatherer::body(const Body& b)
	{
		const Body::id_t id    = b.getId();
		const State&     s     = *b.state;
		rcr::StepBody&   body  = step_.bodies[id];
		const bool       clump = b.isClump();
		if (b.shape && !clump) body.shape = plane::shapeOf(*b.shape, s, from_.z);
		if ((clump || body.shape.kind != rcr::PlanarShape::none) && body.shape.kind != rcr::PlanarShape::wall
		    && body.shape.kind != rcr::PlanarShape::segment && !gate::fine(b, body.shape, from_.z))
			gate::refuseBody(b, scene_, from_.z);
		from_.state[id]    = b.state.get();
		body.center        = plane::toPlane(s.pos);
		body.turn          = plane::turnOf(body.shape, s);
		body.velocity      = plane::twist(s);
		body.radius        = body.shape.radius();
		body.alertDistance = rcr::alertDistance(body.shape, body.velocity, step_.dt);
		if (b.isClumpMember()) {
			body.owner          = b.clumpId;
			const State& moving = *(*scene_.bodies)[b.clumpId]->state;
			rcr::StepBody owner;
			owner.center = plane::toPlane(moving.pos);
			if (moving.blockedDOFs != State::DOF_ALL) foresee(b, memberVelocity(body, owner, plane::twist(moving)), body);
		} else {
			body.free = s.blockedDOFs != State::DOF_ALL;
			if (body.free) foresee(b, body.velocity, body);
			move(b, s, body);
		}
		from_.bound[id] = b.bound.get();
		// An obstacle's box is not enlarged by its alert distance: where it outruns the collider's margin, it looks by itself. So does a mobile one.
		if (!body.shape.grain() && b.bound && body.alertDistance > double(b.bound->sweepLength)) body.expected = 0;
	}

	/// How far a body may go at its velocity, which a script may have set since the collider last ran: then it looks by itself. In a cell, with which
	/// boxes and bodies move between two looks, it is the way beside it that counts.
	void Gatherer::foresee(const Body& b, const rcr::Twist& velocity, rcr::StepBody& body)
	{
		bool unseen = b.bound && body.shape.grain();
		if (unseen && scene_.isPeriodic) {
			const rcr::Vec2 flow = step_.cell.drift(body.center);
			unseen = step_.dt * rcr::speed({ velocity.x - flow.x, velocity.y - flow.y, velocity.rotation }, body.radius) > double(b.bound->sweepLength);
		} else if (unseen)
			unseen = outreaches(body, b.state->pos, velocity, step_.dt, *b.bound);
		body.expected = unseen ? 0 : body.alertDistance;
	}

	/// Inverse mass, and the velocity at the end of the step without contacts: what NewtonIntegrator will make of the forces so far.
	void Gatherer::move(const Body& b, const State& s, rcr::StepBody& body)
	{
		if (newton_.mask > 0 && !b.maskCompatible(newton_.mask)) return; // the integrator leaves it where it is
		if (step_.overdamped) {
			const rcr::Twist rest = step_.rest.at(body.center);
			if (!(s.blockedDOFs & State::DOF_X)) body.velocity.x = rest.x;
			if (!(s.blockedDOFs & State::DOF_Y)) body.velocity.y = rest.y;
			if (!(s.blockedDOFs & State::DOF_RZ)) body.velocity.rotation = rest.rotation;
		}
		const Body::id_t  id      = b.getId();
		const double      dt      = step_.dt;
		const auto        load    = this->load(b);
		const auto        free    = [&](unsigned dof) { return !(s.blockedDOFs & dof); };
		rcr::Twist&       v       = step_.problem.freeVelocity[id];
		rcr::InverseMass& inverse = step_.problem.inverseMass[id];
		if (!math::isfinite(load.first.sum() + load.second[2])) gate::refuseBody(b, scene_, from_.z);
		v = body.velocity;
		if (free(State::DOF_X)) {
			inverse.x = 1 / double(s.mass);
			v.x += dt * double(load.first[0] / s.mass + newton_.gravity[0]);
		}
		if (free(State::DOF_Y)) {
			inverse.y = 1 / double(s.mass);
			v.y += dt * double(load.first[1] / s.mass + newton_.gravity[1]);
		}
		if (free(State::DOF_RZ)) {
			inverse.rotation = 1 / double(s.inertia[2]);
			v.rotation += dt * double(load.second[2] / s.inertia[2]);
		}
		if (!field_.periodic) return;
		const rcr::Twist more = field_.added(s, dt);
		v                     = { v.x + more.x, v.y + more.y, v.rotation + more.rotation };
	}

	/// Force and torque on a body, on a clump with those on its members.
	std::pair<Vector3r, Vector3r> Gatherer::load(const Body& b) const
	{
		Vector3r force = scene_.forces.getForce(b.getId()), torque = scene_.forces.getTorque(b.getId());
		if (b.isClump()) static_cast<Clump&>(*b.shape).addForceTorqueFromMembers(b.state.get(), &scene_, force, torque);
		return { force, torque };
	}

	StepSources::Contact Gatherer::contactOf(Interaction& i) const
	{
		if (!i.functorCache.geomExists) gate::checkServed(i, scene_);
		if (!i.isReal()) return {};
		CdPhys*  phys = dynamic_cast<CdPhys*>(i.phys.get());
		RcrGeom* geom = i.geom->getClassIndex() == RcrGeom::getClassIndexStatic() ? static_cast<RcrGeom*>(i.geom.get()) : nullptr;
		if (!phys && !geom) return {};
		if (!phys || !geom)
			gate::refuse(
			        "the contact of bodies #" + std::to_string(i.getId1()) + " and #" + std::to_string(i.getId2()) + " has the geometry "
			        + i.geom->getClassName() + " and the physics " + i.phys->getClassName()
			        + "; wanted RcrGeom and CdPhys: take Ig2_…_RcrGeom and Ip2_FrictMat_FrictMat_CdPhys alone, and O.interactions.clear() after a change.");
		return { geom, phys, &i, i.getId1(), i.getId2(), geom->points };
	}

	/// Sorted by the ids, since the order of YADE's container changes when a scene is reloaded: counted into place by the first
	/// id, then the few of one body by the second.
	void Gatherer::sort()
	{
		std::vector<int>& first = step_.firstOf;
		first.assign(step_.bodies.size() + 1, 0);
		for (const StepSources::Contact& contact : from_.found)
			if (contact.points > 0) ++first[contact.id1 + 1];
		std::partial_sum(first.begin(), first.end(), first.begin());
		from_.sorted.resize(first.back());
		std::vector<int> next = first;
		for (const StepSources::Contact& contact : from_.found)
			if (contact.points > 0) from_.sorted[next[contact.id1]++] = contact;
		team_.forEach(step_.bodies.size(), [&](Body::id_t id) {
			const auto begin = from_.sorted.begin();
			std::sort(begin + first[id], begin + first[id + 1], [](const auto& a, const auto& b) { return a.id2 < b.id2; });
		});
	}

	void Gatherer::contacts()
	{
		InteractionContainer& interactions = *scene_.interactions;
		from_.found.resize(interactions.size());
		team_.forEach(from_.found.size(), [&](int k) {
			prefetchContact(interactions, from_.found.size(), k);
			from_.found[k] = contactOf(*interactions[k]);
		});
		sort();
		step_.contacts.resize(from_.sorted.size());
		int points = 0;
		for (std::size_t k = 0; k < from_.sorted.size(); ++k) {
			const StepSources::Contact& source = from_.sorted[k];
			step_.contacts[k]                  = { source.id1, source.id2, points, source.points, int(k), 0, 0, {}, {} };
			points += source.points;
		}
		step_.begin(points);
		team_.forEach(step_.contacts.size(), [&](std::size_t k) {
			const StepSources::Contact& later = from_.sorted[std::min(k + prefetchAhead, from_.sorted.size() - 1)];
			prefetch<RcrGeom>(later.geom);
			prefetch<CdPhys>(later.phys);
			this->points(k);
		});
	}

	void Gatherer::points(std::size_t number)
	{
		rcr::StepContact&           contact = step_.contacts[number];
		const StepSources::Contact& source  = from_.sorted[number];
		const CdPhys&               phys    = *source.phys;
		gate::checkPhys(phys, contact.body1, contact.body2);
		contact.restitution = double(phys.restitution);
		contact.size        = double(source.geom->refR1 + source.geom->refR2);
		if (scene_.isPeriodic) {
			contact.shift = plane::toPlane(scene_.cell->intrShiftPos(source.interaction->cellDist));
			contact.drift = step_.cell.drift(contact.shift);
		}
		const rcr::Impulse force[2] = { { double(phys.force1[0]), double(phys.force1[1]) }, { double(phys.force2[0]), double(phys.force2[1]) } };
		step_.setPoints(contact, source.geom->manifold(), double(phys.tangensOfFrictionAngle), force);
	}

} // namespace

void gather(Scene& scene, const gate::Engines& engines, rcr::ThreadTeam& team, StepSources& sources, rcr::Step& step)
{
	Gatherer gatherer(scene, engines, team, sources, step);
	gatherer.bodies();
	step.problem.inverseStretchMass = step.problem.stretch = {};
	if (engines.cellStress) engines.cellStress->load(step);
	gatherer.contacts();
}

void gatherAgain(Scene& scene, const gate::Engines& engines, rcr::ThreadTeam& team, const std::vector<Body::id_t>& ids, StepSources& sources, rcr::Step& step)
{
	Gatherer gatherer(scene, engines, team, sources, step);
	for (Body::id_t id : ids) {
		gatherer.anew(id);
		rcr::StepBody& body = step.bodies[id];
		if (body.free && body.shape.grain()) body.expected = body.alertDistance; // boxes are not kept up, lists of neighbours are
	}
}

ContactLaw contactLaw(Scene& scene, const InteractionLoop& loop, Body::id_t id1, Body::id_t id2)
{
	shared_ptr<Material>&one = (*scene.bodies)[id1]->material, &two = (*scene.bodies)[id2]->material;
	const auto  scratch = boost::make_shared<Interaction>(id1, id2);
	bool        swap    = false;
	loop.physDispatcher->getFunctor2D(one, two, swap)->go(one, two, scratch);
	const CdPhys* phys = dynamic_cast<const CdPhys*>(scratch->phys.get());
	if (!phys)
		gate::refuse(
		        "the contact of bodies #" + std::to_string(id1) + " and #" + std::to_string(id2) + " gets the physics "
		        + (scratch->phys ? scratch->phys->getClassName() : std::string("None")) + " from the Ip2 functor of the materials "
		        + one->getClassName() + " and " + two->getClassName() + "; wanted CdPhys: take Ip2_FrictMat_FrictMat_CdPhys for them.");
	gate::checkPhys(*phys, id1, id2);
	return { double(phys->tangensOfFrictionAngle), double(phys->restitution) };
}

bool mayMeet(Scene& scene, const gate::Engines& engines, Body::id_t id1, Body::id_t id2)
{
	Body &one = *(*scene.bodies)[id1], &two = *(*scene.bodies)[id2];
	bool  swap;
#ifdef YADE_MPI
	if (!engines.collider->mayCollide(&one, &two, scene.subdomain)) return false;
#else
	if (!engines.collider->mayCollide(&one, &two)) return false;
#endif
	return one.isBounded() && two.isBounded() && engines.loop->geomDispatcher->getFunctor2D(one.shape, two.shape, swap)
	        && dynamic_cast<const FrictMat*>(one.material.get()) && dynamic_cast<const FrictMat*>(two.material.get());
}

} // namespace yade

#include "dem/transfer/gather.hpp"

#include "dem/loads/CellStress.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "kernel/problem/list_by_key.hpp"

namespace yade {

namespace {

	struct Gatherer {
		Scene&                     scene_;
		const validation::Engines& engines_;
		rcr::ThreadTeam&           team_;
		SceneHandles&              handles_;
		rcr::Step&                 step_;

		void bodies()
		{
			const BodyContainer& bodies = *scene_.bodies;
			const std::size_t    count  = bodies.size();
			step_.dt                    = double(scene_.dt);
			step_.problem.inverseMass.resize(count);
			step_.problem.freeVelocity.resize(count);
			step_.bodies.resize(count);
			handles_.state.resize(count);
			handles_.bound.resize(count);
			handles_.mayLackContacts.assign(count, false);
			handles_.z = validation::planeOf(scene_);
			team_.forEach(count, [&](Body::id_t id) { gatherBody(id); });
			step_.members.clear();
			for (std::size_t id = 0; id < count; ++id) {
				const int owner = step_.bodies[id].owner;
				if (owner == int(id)) continue;
				step_.members.push_back(int(id));
				step_.widenClump(int(id));
			}
			listWallPairs();
		}

		/// Lists parallel walls of which one is free along its normal.
		void listWallPairs()
		{
			std::vector<int> walls;
			for (std::size_t id = 0; id < step_.bodies.size(); ++id)
				if (step_.bodies[id].shape.kind == rcr::PlanarShape::wall) walls.push_back(int(id));
			const auto isFree = [&](int id) {
				const rcr::InverseMass& inverse = step_.problem.inverseMass[id];
				return (step_.bodies[id].shape.axis == 0 ? inverse.x : inverse.y) > 0;
			};
			step_.wallPairs.clear();
			for (auto one = walls.begin(); one != walls.end(); ++one)
				for (auto two = one + 1; two != walls.end(); ++two) {
					const int id1 = *one, id2 = *two;
					if (step_.bodies[id1].shape.axis == step_.bodies[id2].shape.axis
					        && (isFree(id1) || isFree(id2))
					        && validation::mayCollide(scene_, *engines_.collider, id1, id2))
						step_.wallPairs.push_back({ id1, id2 });
				}
		}

		void gatherBody(Body::id_t id)
		{
			rcr::StepBody& body            = step_.bodies[id];
			step_.problem.inverseMass[id]  = {};
			step_.problem.freeVelocity[id] = {};
			body                           = {};
			body.owner                     = id;
			const Body* const there        = (*scene_.bodies)[id].get();
			handles_.state[id]             = there ? there->state.get() : nullptr;
			handles_.bound[id]             = there ? there->bound.get() : nullptr;
			if (!there) return;
			const Body&  b = *there;
			const State& s = *b.state;
			if (b.shape) body.shape = plane::shapeOf(*b.shape, s, handles_.z);
			const std::string error = validation::bodyError(b, body.shape, handles_.z);
			if (!error.empty()) errors::refuse(error);
			body.center        = plane::toPlane(s.pos);
			body.turn          = plane::turnOf(body.shape, s);
			body.velocity      = plane::velocityOf(s);
			body.radius        = body.shape.radius();
			body.alertDistance = rcr::alertDistance(body.shape, body.velocity, step_.dt);
			if (b.isClumpMember()) {
				const State& clump = *(*scene_.bodies)[b.clumpId]->state;
				body.owner         = b.clumpId;
				body.velocity      = rcr::memberVelocity(
				        body, plane::toPlane(clump.pos), plane::velocityOf(clump));
				// Ig2 functors read the velocity of a member as of the last motion of its clump
				const double detected = body.alertDistance + 1e-9 * body.radius;
				body.alertDistance    = rcr::alertDistance(body.shape, body.velocity, step_.dt);
				body.coveredPath      = body.alertDistance;
				handles_.mayLackContacts[id]
				        = body.alertDistance > detected || mayLackContacts(b, body);
			} else {
				body.free = s.blockedDOFs != State::DOF_ALL;
				if (body.free) body.coveredPath = body.alertDistance;
				handles_.mayLackContacts[id] = mayLackContacts(b, body);
				setFreeMotion(b, s, body);
			}
		}

		/// Returns true if a body, enlarged by its alert distance, leaves its box. The collider may
		/// then not list all its contacts. An example is a velocity set by a script.
		bool mayLackContacts(const Body& b, const rcr::StepBody& body) const
		{
			if (!b.bound) return false;
			return body.shape.grain()
			        ? grainLeavesBox(scene_, step_, body, b.state->pos, body.velocity, *b.bound)
			        : obstacleLeavesBox(scene_, body.shape, body.pose(), handles_.z,
			                body.alertDistance, *b.bound);
		}

		/// Sets the inverse mass, and the velocity that NewtonIntegrator would compute without
		/// contacts.
		void setFreeMotion(const Body& b, const State& s, rcr::StepBody& body)
		{
			const NewtonIntegrator& newton = *engines_.integrator;
			if (newton.mask > 0 && !b.maskCompatible(newton.mask)) {
				body.velocity = {}; // the integrator does not move it
				return;
			}
			const rcr::Inertia inertia = plane::inertiaOf(s);
			beginStep(step_, b.getId(), body.velocity, inertia, externalForce(b),
			        plane::toPlane(newton.gravity));
			step_.problem.inverseMass[b.getId()] = { inertia.freeX ? 1 / inertia.mass : 0,
				inertia.freeY ? 1 / inertia.mass : 0,
				inertia.freeRotation ? 1 / inertia.moment : 0 };
		}

		/// Force and torque on a body, or on a clump and its members.
		rcr::PlanarVector externalForce(const Body& b) const
		{
			Vector3r force  = scene_.forces.getForce(b.getId()),
			         torque = scene_.forces.getTorque(b.getId());
			if (b.isClump())
				static_cast<Clump&>(*b.shape).addForceTorqueFromMembers(
				        b.state.get(), &scene_, force, torque);
			if (!math::isfinite(force.sum() + torque[2]))
				errors::refuse(errors::bodyNames({ b.getId() }), " has the force ",
				        errors::coordinates(force), " and the torque ",
				        errors::coordinates(torque),
				        "; expected finite numbers: find the engine, or the O.forces of a script, "
				        "that gave them.");
			return { double(force[0]), double(force[1]), double(torque[2]) };
		}

		SceneHandles::Contact contactOf(Interaction& i) const
		{
			const Body::id_t id1 = i.getId1(), id2 = i.getId2();
			if (!i.functorCache.geomExists) validation::refuseUnsupported(scene_, id1, id2);
			if (!i.isReal()) return {};
			if (step_.bodies[id1].owner == step_.bodies[id2].owner) { // a clump has joined them
				i.reset();
				return {};
			}
			CdPhys*  phys = dynamic_cast<CdPhys*>(i.phys.get());
			RcrGeom* geom = i.geom->getClassIndex() == RcrGeom::getClassIndexStatic()
			        ? static_cast<RcrGeom*>(i.geom.get())
			        : nullptr;
			if (!phys || !geom)
				errors::refuse("the contact of ", errors::bodyNames({ id1, id2 }),
				        " has the geometry ", i.geom->getClassName(), " and the physics ",
				        i.phys->getClassName(),
				        "; expected RcrGeom and CdPhys: use only Ig2_…_RcrGeom and "
				        "Ip2_FrictMat_FrictMat_CdPhys, and call O.interactions.clear() after a "
				        "change of functors.");
			return { geom, phys, &i, id1, id2, geom->points };
		}

		/// Sorts contacts by body 1, then body 2: YADE's container changes its order when a scene is
		/// reloaded.
		void sort(const std::vector<SceneHandles::Contact>& found)
		{
			std::vector<std::int32_t> first;
			rcr::listByKey(step_.bodies.size(), first, handles_.sorted, [&](auto add) {
				for (const SceneHandles::Contact& contact : found)
					if (contact.points > 0) add(contact.id1, contact);
			});
			team_.forEach(step_.bodies.size(), [&](Body::id_t id) {
				const auto begin = handles_.sorted.begin();
				std::sort(begin + first[id], begin + first[id + 1],
				        [](const auto& a, const auto& b) { return a.id2 < b.id2; });
			});
		}

		void contacts()
		{
			InteractionContainer& interactions = *scene_.interactions;
			std::vector<SceneHandles::Contact> found(interactions.size());
			team_.forEach(found.size(), [&](int k) { found[k] = contactOf(*interactions[k]); });
			sort(found);
			step_.contacts.resize(handles_.sorted.size());
			int points = 0;
			for (std::size_t k = 0; k < handles_.sorted.size(); ++k) {
				const SceneHandles::Contact& source = handles_.sorted[k];
				step_.contacts[k] = { source.id1, source.id2, points, source.points, int(k), {}, 0, {},
					{} };
				points += source.points;
			}
			step_.resizePoints(points);
			team_.forEach(step_.contacts.size(), [&](std::size_t k) { gatherPoints(k); });
		}

		void gatherPoints(std::size_t number)
		{
			rcr::StepContact&            contact = step_.contacts[number];
			const SceneHandles::Contact& source  = handles_.sorted[number];
			const CdPhys&                phys    = *source.phys;
			validation::checkPhys(phys, contact.body1, contact.body2);
			contact.law  = phys.law();
			contact.size = double(source.geom->refR1 + source.geom->refR2);
			if (scene_.isPeriodic) {
				const Vector3i& cells = source.interaction->cellDist;
				contact.shift         = plane::toPlane(scene_.cell->intrShiftPos(cells));
				contact.drift         = step_.cell.drift(contact.shift);
			}
			const rcr::LocalVector force[2] = { { double(phys.force1[0]), double(phys.force1[1]) },
				{ double(phys.force2[0]), double(phys.force2[1]) } };
			step_.setPoints(contact, source.geom->manifold(), force,
			        double(phys.rollingMoment));
		}
	};

} // namespace

bool grainLeavesBox(const Scene& scene, const rcr::Step& step, const rcr::StepBody& b,
        const Vector3r& at, const rcr::PlanarVector& v, const Bound& bound)
{
	double   extent = b.radius + rcr::alertDistance(b.shape, v, step.dt);
	Vector3r moved  = at - bound.refPos;
	if (scene.isPeriodic) {
		extent += rcr::imageReach(b.shape, step.cell.imageSpeed, step.dt);
		moved = scene.cell->unshearPt(at) - 0.5 * (bound.min + bound.max);
	}
	extent *= 1 - 1e-9; // a grain at rest fills its box
	const Vector3r widening = boxWidening(scene);
	for (int axis : { 0, 1 })
		if (std::abs(double(moved[axis])) + extent * double(widening[axis])
		        > 0.5 * double(bound.max[axis] - bound.min[axis]))
			return true;
	return false;
}

/// The bounding box of an obstacle in unsheared space.
static rcr::BoundingBox unshearedBounds(
        const Cell& cell, const rcr::PlanarShape& shape, const rcr::Pose& at)
{
	const auto unsheared
	        = [&](rcr::Vec2 v) { return plane::toPlane(cell.unshearPt(plane::toSpace(v))); };
	std::vector<rcr::Vec2> points = rcr::coreVertices(shape, at);
	if (points.empty()) points.push_back(at.center); // a wall
	for (rcr::Vec2& point : points)
		point = unsheared(point);
	return rcr::boundsOf(points);
}

bool obstacleLeavesBox(const Scene& scene, const rcr::PlanarShape& shape, const rcr::Pose& at,
        Real z, double margin, const Bound& bound)
{
	if (shape.kind == rcr::PlanarShape::none) return false;
	const double rounding = 1e-9 * (shape.radius() + margin); // a body at rest fills its box
	const Real   slack    = 1e-9 * (bound.max[2] - bound.min[2]);
	// a Wall that was parallel to the plane
	if (z < bound.min[2] - slack || z > bound.max[2] + slack) return true;
	const rcr::BoundingBox box = scene.isPeriodic ? unshearedBounds(*scene.cell, shape, at)
	                                              : rcr::boundsOf(shape, at);
	const Vector3r widening = boxWidening(scene);
	const auto     out      = [&](int axis, double center, double half) {
        half += margin * double(widening[axis]) - rounding;
        return center + half > double(bound.max[axis]) || center - half < double(bound.min[axis]);
	};
	return out(0, box.center.x, box.half.x) || out(1, box.center.y, box.half.y);
}

void gatherCell(const Scene& scene, const validation::Engines& engines, rcr::Step& step)
{
	step.cell = plane::cellOf(scene);
	if (!scene.isPeriodic) return;
	const Matrix3r& before   = engines.integrator->prevVelGrad;
	Matrix3r        gradient = plane::nextGradient(*scene.cell);
	if (scene.cell->homoDeform > 0) step.cell.change = plane::flowOf(gradient - before);
	if (scene.cell->homoDeform > 1) step.cell.convection = plane::flowOf(before);
	if (engines.cellStress) engines.cellStress->clearStressedAxes(gradient);
	step.startFlow = plane::flowOf(gradient);
}

void gatherCellStress(const validation::Engines& engines, rcr::Step& step)
{
	step.problem.inverseStretchMass = step.problem.stretchRate = {};
	step.problem.place.clear();
	if (engines.cellStress) engines.cellStress->gatherCell(*engines.integrator, step);
}

/// A drive that accelerates in contact hits nothing: impacts have its velocity of the last step.
static void setDrivesBefore(const Drives& before, const SceneHandles& handles, rcr::Step& step)
{
	for (std::size_t k = 0; k < before.bodies.size(); ++k) {
		const std::size_t id = before.bodies[k];
		const Vector3r&   v  = before.velocities[k];
		if (id < step.bodies.size() && handles.state[id])
			rcr::setDriveBefore(step, { int(id), { double(v[0]), double(v[1]), double(v[2]) } });
	}
}

void gather(Scene& scene, const validation::Engines& engines, rcr::ThreadTeam& team,
        const Drives& before, SceneHandles& handles, rcr::Step& step)
{
	Gatherer gatherer { scene, engines, team, handles, step };
	gatherCell(scene, engines, step);
	gatherer.bodies();
	setDrivesBefore(before, handles, step);
	gatherCellStress(engines, step);
	gatherer.contacts();
}

void regatherBodies(Scene& scene, const validation::Engines& engines, rcr::ThreadTeam& team,
        const std::vector<Body::id_t>& ids, SceneHandles& handles, rcr::Step& step)
{
	Gatherer gatherer { scene, engines, team, handles, step };
	for (Body::id_t id : ids)
		gatherer.gatherBody(id);
	for (Body::id_t id : ids)
		step.widenClump(id);
}

} // namespace yade

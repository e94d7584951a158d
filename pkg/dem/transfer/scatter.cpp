// Writes the results of steps to YADE's objects.
#include "dem/transfer/scatter.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/ArraySteps.hpp"

namespace yade {

/// Writes the forces of both contact points and their sums; a missing point has the force 0.
static void writeForce(
        CdPhys& phys, const rcr::LocalVector (&force)[2], const rcr::Vec2 (&normal)[2])
{
	phys.force1      = Vector2r(force[0].n, force[0].t);
	phys.force2      = Vector2r(force[1].n, force[1].t);
	phys.normalForce = plane::toSpace(force[0].n * normal[0] + force[1].n * normal[1]);
	phys.shearForce  = plane::toSpace(force[0].t * perp(normal[0]) + force[1].t * perp(normal[1]));
}

static void writeForces(const rcr::Step& step, const rcr::StepContact& contact, CdPhys& phys)
{
	rcr::LocalVector force[2];
	rcr::Vec2        normal[2];
	for (int k = 0; k < contact.count; ++k) {
		const rcr::ContactPoint& c = step.problem.points[contact.first + k];
		force[k]                   = step.force[contact.first + k];
		normal[k]                  = c.normal;
		phys.bias[k]               = c.bias;
	}
	writeForce(phys, force, normal);
	phys.rollingMoment = contact.count == 1
	        ? step.rollingMoment[contact.first] : 0;
}

/// Returns the interaction of a pair; creates it if there is none.
static Interaction& interactionOf(Scene& scene, const rcr::Pair& pair)
{
	shared_ptr<Interaction> i = scene.interactions->find(pair.body1, pair.body2);
	if (!i) {
		i = boost::make_shared<Interaction>(pair.body1, pair.body2);
		scene.interactions->insert(i);
	}
	if (!i->geom && i->getId1() != pair.body1) i->swapOrder();
	return *i;
}

/// Writes the points of a pair to its interaction. Creates the CdPhys of a contact that formed in
/// arrays (`Pair::formedAt` ≥ 0). `at2`: pose of body 2 or of its image.
static SceneHandles::Contact writeContact(Interaction& i, const rcr::Pair& pair,
        const rcr::Manifold& manifold, const SceneHandles& handles, const rcr::Step& step,
        const rcr::Pose& at2)
{
	if (!i.geom) i.geom = boost::make_shared<RcrGeom>();
	if (pair.formedAt >= 0) {
		auto phys = boost::make_shared<CdPhys>();
		phys->setLaw(pair.law);
		i.phys         = phys;
		i.iterMadeReal = pair.formedAt;
	}
	RcrGeom&             geom = static_cast<RcrGeom&>(*i.geom);
	CdPhys&              phys = static_cast<CdPhys&>(*i.phys);
	const rcr::StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
	geom.set(manifold, one.shape, one.pose(), two.shape, at2, handles.state[pair.body2]->pos.z());
	phys.points = geom.points;
	phys.along  = geom.along;
	return { &geom, &phys, &i, pair.body1, pair.body2, geom.points };
}

/// Writes added contacts as InteractionLoop would have made them.
static void addContacts(Scene& scene, SceneHandles& handles, rcr::Step& step)
{
	for (const rcr::FoundContact& found : step.added) {
		const auto k = step.find(found.body1, found.body2) - step.contacts.data();
		step.contacts[k].handleIndex = int(handles.sorted.size());
		rcr::Pair pair;
		pair.body1 = found.body1, pair.body2 = found.body2;
		Interaction& i = interactionOf(scene, pair);
		if (scene.isPeriodic && !i.geom) // the collider may have listed another image
			i.cellDist = plane::cellsOf(*scene.cell, found.shift);
		if (!i.phys) {
			pair.law      = found.law;
			pair.formedAt = scene.iter;
		}
		handles.sorted.push_back(writeContact(i, pair, found.manifold, handles, step,
		        shifted(step.bodies[found.body2].pose(), found.shift)));
	}
}

void deformCell(Cell& cell, const rcr::PeriodicCell& now, rcr::Vec2 strain)
{
	Matrix3r displaced = Matrix3r::Identity();
	displaced(0, 0) += strain.x, displaced(1, 1) += strain.y;
	cell.hSize = displaced * cell.hSize;
	cell.trsf  = displaced * cell.trsf;
	cell.integrateAndUpdate(0); // updates its derived data
	Matrix3r gradient = plane::nextGradient(cell);
	for (int axis = 0; axis < 2; ++axis)
		gradient(axis, axis) = now.gradient[axis][axis];
	cell.setVelGrad(gradient);
}

/// Largest displacement of an image along a base vector in a step [m]. A corner image moves up to
/// twice as far (PeriodicCell::largestDrift). The boxes of both bodies together cover this.
static double largestImageDisplacement(const rcr::Step& step)
{
	const rcr::PeriodicCell& cell = step.cell;
	if (!cell.periodic) return 0;
	double farthest = 0;
	for (int k = 0; k < 2; ++k)
		farthest = std::max(farthest, norm(cell.drift({ cell.h[0][k], cell.h[1][k] })));
	return step.dt * farthest;
}

/// Requests a run of the collider if a grain, enlarged by its alert distance, or an obstacle leaves
/// its box. YADE checks displacements only, neither rotations nor shapes.
static void requestCollider(
        Scene& scene, rcr::ThreadTeam& team, const SceneHandles& handles, const rcr::Step& step)
{
	const Real widest = scene.isPeriodic ? 0.45 * scene.cell->getSize().minCoeff() // YADE: 0.5
	                                     : std::numeric_limits<Real>::infinity();
	// boxes do not follow images of bodies at rest
	const double imageStep = largestImageDisplacement(step);
	std::atomic<bool> out { false };
	team.forEach(step.bodies.size(), [&](Body::id_t id) {
		const Bound* bound = handles.bound[id];
		if (!bound) return;
		const rcr::StepBody&     b = step.bodies[id];
		const rcr::PlanarVector& v = step.problem.velocity[id];
		const bool               imagesLeave = imageStep > 0
		        && double(scene.iter - bound->lastUpdateIter + 2) * imageStep
		                > double(bound->sweepLength);
		const bool leaves = imagesLeave || bound->max[0] - bound->min[0] > widest
		        || (b.shape.grain()
		                        ? grainLeavesBox(scene, step, b,
		                                handles.state[id]->pos + step.dt * Vector3r(v.x, v.y, 0), v,
		                                *bound)
		                        : obstacleLeavesBox(scene, b.shape,
		                                rcr::poseAfter(b, step.bodies[b.owner],
		                                        step.problem.velocity[b.owner], step.dt),
		                                handles.z, 0, *bound));
		if (leaves) out.store(true, std::memory_order_relaxed);
	});
	if (out) scene.doSort = true;
}

void setUnblockedVelocity(State& s, const rcr::PlanarVector& velocity)
{
	const Vector3r vel(velocity.x, velocity.y, 0), spin(0, 0, velocity.rotation);
	for (int axis = 0; axis < 3; ++axis) {
		if (!(s.blockedDOFs & State::axisDOF(axis))) s.vel[axis] = vel[axis];
		if (!(s.blockedDOFs & State::axisDOF(axis, true))) s.angVel[axis] = spin[axis];
	}
}

void displace(State& s, const rcr::PlanarVector& by)
{
	s.pos += Vector3r(by.x, by.y, 0);
	if (by.rotation != 0)
		s.ori = (Quaternionr(AngleAxisr(by.rotation, Vector3r::UnitZ())) * s.ori).normalized();
}

std::vector<rcr::PlanarVector> contactImpulses(const rcr::Step& step)
{
	std::vector<rcr::PlanarVector> impulses(step.bodies.size());
	const rcr::InverseMass         unit = { 1, 1, 1 };
	// one order for any number of threads
	for (std::size_t k = 0; k < step.problem.points.size(); ++k) {
		const rcr::ContactPoint& c = step.problem.points[k];
		applyImpulse(c, step.problem.impulse[k], unit, unit, impulses[c.body1], impulses[c.body2]);
		applyRollingImpulse(c, step.problem.rollingImpulseOf(k), unit, unit, impulses[c.body1],
		        impulses[c.body2]);
	}
	return impulses;
}

void scatter(Scene& scene, rcr::ThreadTeam& team, const std::vector<rcr::PlanarVector>& impulses,
        SceneHandles& handles, rcr::Step& step)
{
	addContacts(scene, handles, step);
	team.forEach(step.contacts.size(), [&](std::size_t k) {
		const rcr::StepContact& contact = step.contacts[k];
		writeForces(step, contact, *handles.sorted[contact.handleIndex].phys);
	});
	const double inverseDt = 1 / step.dt;
	team.forEach(step.bodies.size(), [&](Body::id_t id) {
		const rcr::StepBody& body = step.bodies[id];
		const rcr::PlanarVector& p = impulses[id];
		if (p.x != 0 || p.y != 0 || p.rotation != 0) {
			scene.forces.addForceUnsynced(id, inverseDt * Vector3r(p.x, p.y, 0));
			scene.forces.addTorqueUnsynced(id, inverseDt * Vector3r(0, 0, p.rotation));
		}
		if (!handles.state[id] || body.owner != id) return;
		if (step.overdamped)
			setUnblockedVelocity(*handles.state[id], step.stretched(id, body.velocity));
		if (!step.displacement.empty() && (body.free || step.problem.stretches()))
			displace(*handles.state[id], step.displacement[id]);
	});
	if (step.problem.stretches()) deformCell(*scene.cell, step.cell, step.strain);
	requestCollider(scene, team, handles, step);
}

void ArraySteps::writeBack(
        Scene& scene, rcr::ThreadTeam& team, SceneHandles& handles, const rcr::Step& step)
{
	if (!active_) return;
	active_      = false;
	scene.doSort = true; // the collider has not run during the steps in arrays
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		State* s = handles.state[id];
		const rcr::StepBody& body = step.bodies[id];
		if (!s || isSynced_[id] || body.owner != int(id)) return;
		const rcr::PlanarVector& v = endVelocity_[id];
		// a state that a script has written meanwhile stays
		const Motion before = written_[id], now = motionOf(*s);
		if (now.center == before.center) s->pos[0] = body.center.x, s->pos[1] = body.center.y;
		if (now.turn == before.turn) s->ori.w() = body.turn.w, s->ori.z() = body.turn.z;
		if (now.velocity == before.velocity)
			s->vel[0] = v.x, s->vel[1] = v.y, s->angVel[2] = v.rotation;
	});
	team.forEach(clumps_.size(), [&](std::size_t k) {
		Clump::moveMembers<NewtonIntegrator>((*scene.bodies)[clumps_[k].id], &scene);
	});

	std::vector<Interaction*> interaction(pairs_.all.size());
	std::vector<char>         lasts(handles.sorted.size());
	// false for a new pair after an error
	const auto                made = [](const rcr::Pair& pair) {
        return pair.pointCount > 0 && (pair.handleIndex >= 0 || pair.formedAt >= 0);
	};
	for (std::size_t k = 0; k < interaction.size(); ++k) {
		const int index = pairs_.all[k].handleIndex;
		if (!made(pairs_.all[k]) || index < 0) continue;
		lasts[index]   = true;
		interaction[k] = handles.sorted[index].interaction;
	}
	for (std::size_t k = 0; k < lasts.size(); ++k)
		if (!lasts[k] && handles.sorted[k].interaction) handles.sorted[k].interaction->reset();
	for (std::size_t k = 0; k < interaction.size(); ++k)
		if (made(pairs_.all[k]) && !interaction[k])
			interaction[k] = &interactionOf(scene, pairs_.all[k]);
	std::vector<SceneHandles::Contact> contacts(interaction.size());
	team.forEach(interaction.size(), [&](std::size_t k) {
		if (!interaction[k]) return;
		const rcr::Pair&     pair     = pairs_.all[k];
		const rcr::Manifold& manifold = pairs_.manifold[k];
		if (scene.isPeriodic)
			interaction[k]->cellDist = plane::cellsOf(*scene.cell, pair.shift);
		contacts[k] = writeContact(*interaction[k], pair, manifold, handles, step,
		        shifted(step.bodies[pair.body2].pose(), pair.shift));
		writeForce(*contacts[k].phys, pair.force,
		        { manifold.points[0].normal, manifold.points[1].normal });
		contacts[k].phys->rollingMoment = pair.pointCount == 1 ? pair.rollingMoment : 0;
	});
	handles.sorted.swap(contacts);
}

} // namespace yade

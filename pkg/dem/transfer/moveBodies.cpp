// Moves bodies and cell of steps in arrays, with the bits of YADE's NewtonIntegrator.
#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/ArraySteps.hpp"
#include "dem/transfer/scatter.hpp"

namespace yade {

/// Applies displacements and start velocities of the step, as `scatter`.
void ArraySteps::displaceSynced(const SceneHandles& handles, const rcr::Step& step) const
{
	for (Body::id_t id : synced_) {
		const rcr::StepBody& body = step.bodies[id];
		if (body.owner != id) continue;
		State& s = *handles.state[id];
		if (step.overdamped) setUnblockedVelocity(s, step.stretched(id, body.velocity));
		if (!step.displacement.empty() && (body.free || step.problem.stretches()))
			displace(s, step.displacement[id]);
	}
}

/// Moves synced bodies. Obstacles need not lie in the plane.
void ArraySteps::moveSynced(Scene& scene, const NewtonIntegrator& newton,
        const SceneHandles& handles, const Impulses& impulses, const rcr::Step& step) const
{
	const Cell&    cell     = *scene.cell;
	const int      flow     = scene.isPeriodic ? cell.homoDeform : 0;
	const Matrix3r& before  = newton.prevVelGrad;
	const Matrix3r change   = cell.velGrad - before;
	for (Body::id_t id : synced_) {
		if (step.bodies[id].owner != id) continue;
		const shared_ptr<Body>&  b = (*scene.bodies)[id];
		State&                   s = *handles.state[id];
		const rcr::PlanarVector& p = impulses[id];
		Vector3r force  = scene.forces.getForce(id) + 1 / step.dt * Vector3r(p.x, p.y, 0),
		         torque = scene.forces.getTorque(id) + 1 / step.dt * Vector3r(0, 0, p.rotation);
		if (b->isClump()) {
			Vector3r ofMembers = Vector3r::Zero(), torques = Vector3r::Zero();
			static_cast<Clump&>(*b->shape).addForceTorqueFromMembers(
			        &s, &scene, ofMembers, torques);
			force += ofMembers, torque += torques;
		}
		const Vector3r convection = flow > 1 ? Vector3r(before * s.vel) : Vector3r(Vector3r::Zero());
		const bool     isFixed    = s.blockedDOFs == State::DOF_ALL;
		for (int axis = 0; axis < 3; ++axis) {
			const bool moves = !(s.blockedDOFs & State::axisDOF(axis));
			if (!isFixed)
				s.vel[axis] += scene.dt
				        * ((moves ? force[axis] / s.mass + newton.gravity[axis] : 0)
				                + convection[axis]);
			if (!(s.blockedDOFs & State::axisDOF(axis, true)))
				s.angVel[axis] += scene.dt * (torque[axis] / s.inertia[axis]);
		}
		if (isFixed && flow > 1) s.vel += scene.dt * before * s.vel;
		if (flow > 0) {
			s.vel += change * s.pos;
			const Matrix3r spin = .5 * (change - change.transpose());
			s.angVel += Vector3r(-spin(1, 2), spin(0, 2), -spin(0, 1));
		}
		s.pos += s.vel * scene.dt;
		const Real rate = s.angVel.norm();
		if (rate != 0) s.ori = Quaternionr(AngleAxisr(rate * scene.dt, s.angVel / rate)) * s.ori;
		s.ori.normalize();
		if (b->isClump()) Clump::moveMembers<NewtonIntegrator>(b, &scene);
	}
}

/// Enters kinetic energy and work of gravity, as NewtonIntegrator::updateEnergy. Bodies have its
/// threads, on which the order of the sums depends.
void ArraySteps::enterEnergies(Scene& scene, NewtonIntegrator& newton,
        const SceneHandles& handles, const rcr::Step& step) const
{
	struct Plain {
		Vector3r pos, vel, angVel, inertia;
		Real     mass;
	};
	const auto of = [&](Body::id_t id) -> Plain {
		const State& s = *handles.state[id];
		if (isSynced_[id]) return { s.pos, s.vel, s.angVel, s.inertia, s.mass };
		rcr::StepBody body = step.bodies[id];
		if (!step.displacement.empty() && (body.free || step.problem.stretches()))
			rcr::displace(body, step.displacement[id]);
		const rcr::PlanarVector& v = endVelocity_[id];
		return { Vector3r(body.center.x, body.center.y, handles.z), Vector3r(v.x, v.y, 0),
			Vector3r(0, 0, v.rotation), Vector3r(0, 0, inertia_[id].moment), inertia_[id].mass };
	};
	EnergyTracker& energy = *scene.energy;
	BodyContainer& bodies = *scene.bodies;
	bodies.updateRealBodies();
	const bool sparse = bodies.useRedirection;
	const int  count  = int(sparse ? bodies.realBodies.size() : bodies.size());
#pragma omp parallel for
	for (int k = 0; k < count; ++k) {
		const Body::id_t id = sparse ? bodies.realBodies[k] : k;
		if (!handles.state[id] || step.bodies[id].owner != id) continue;
		const Plain    b     = of(id);
		const Vector3r fluctuation
		        = scene.isPeriodic ? Vector3r(b.vel - newton.prevVelGrad * b.pos) : b.vel;
		const Real shift = .5 * b.mass * fluctuation.squaredNorm(),
		           turn  = 0.5 * b.angVel.dot(b.inertia.cwiseProduct(b.angVel));
		if (newton.kinSplit) {
			energy.add(shift, "kinTrans", newton.kinEnergyTransIx, true);
			energy.add(turn, "kinRot", newton.kinEnergyRotIx, true);
		} else
			energy.add(shift + turn, "kinetic", newton.kinEnergyIx, true);
		energy.add(-newton.gravity.dot(b.vel) * b.mass * scene.dt, "gravWork", newton.fieldWorkIx,
		        false);
	}
}

/// Applies a change of O.cell.velGrad, and the motion of the cell by a solved step. Returns what
/// the cell adds to velocities.
static rcr::PeriodicCell applyGradient(
        Scene& scene, NewtonIntegrator& newton, const rcr::Step& step)
{
	rcr::PeriodicCell flow;
	Cell&             cell = *scene.cell;
	if (step.problem.stretches()) deformCell(cell, step.cell, step.strain);
	cell.velGrad        = plane::nextGradient(cell);
	cell.velGradChanged = false, cell.nextVelGrad = Matrix3r::Zero();
	if (cell.homoDeform > 0) flow.change = plane::flowOf(cell.velGrad - newton.prevVelGrad);
	if (cell.homoDeform > 1) flow.convection = plane::flowOf(newton.prevVelGrad);
	return flow;
}

void ArraySteps::move(Scene& scene, const validation::Engines& engines, rcr::ThreadTeam& team,
        const SceneHandles& handles, const Impulses& impulses, rcr::Step& step)
{
	NewtonIntegrator& newton   = *engines.integrator;
	const bool        periodic = scene.isPeriodic, stretches = step.problem.stretches();
	const auto        forEachOwner = [&](auto work) {
		team.forEach(step.bodies.size(), [&](std::size_t id) {
			if (handles.state[id] && !isSynced_[id] && step.bodies[id].owner == int(id)) work(id);
		});
	};
	if (step.overdamped)
		forEachOwner([&](std::size_t id) {
			endVelocity_[id] = startVelocity(endVelocity_[id], inertia_[id],
			        step.stretched(int(id), step.bodies[id].velocity));
		});
	displaceSynced(handles, step);
	const rcr::PeriodicCell flow = periodic ? applyGradient(scene, newton, step) : step.cell;
	if (scene.trackEnergy) enterEnergies(scene, newton, handles, step);
	moveSynced(scene, newton, handles, impulses, step);
	if (periodic) {
		newton.prevCellSize = scene.cell->getSize();
		newton.prevVelGrad = scene.cell->prevVelGrad = scene.cell->velGrad;
	}
	scheduler::beginNextStep(scene);
	gatherCell(scene, engines, step);
	const double    before = step.dt, inverseDt = 1 / before;
	const rcr::Vec2 gravity = plane::toPlane(newton.gravity);
	step.dt                 = double(scene.dt);
	forEachOwner([&](std::size_t id) {
		rcr::StepBody&     body = step.bodies[id];
		rcr::PlanarVector& v    = endVelocity_[id];
		if (!step.displacement.empty() && (body.free || stretches))
			rcr::displace(body, step.displacement[id]);
		const rcr::PlanarVector force = inverseDt * impulses[id];
		v = periodic ? acceleratedInCell(v, inertia_[id], body.free, force, gravity, before, flow,
		                       body.center)
		             : accelerated(v, inertia_[id], force, gravity, before);
		body.velocity = v;
		rcr::move(body, before);
		body.radius        = body.shape.radius();
		body.alertDistance = rcr::alertDistance(body.shape, v, step.dt);
		if (body.free) body.coveredPath = body.alertDistance;
		beginStep(step, id, v, inertia_[id], {}, gravity);
	});
	team.forEach(clumps_.size(), [&](std::size_t k) {
		rcr::StepBody clump = step.bodies[clumps_[k].id];
		clump.velocity      = endVelocity_[clumps_[k].id];
		for (const rcr::ClumpMember& member : clumps_[k].members) {
			rcr::StepBody& body = step.bodies[member.id];
			moveMember(body, member, clump);
			body.alertDistance = body.coveredPath
			        = rcr::alertDistance(body.shape, body.velocity, step.dt);
			step.widenClump(member.id);
		}
	});
}

} // namespace yade

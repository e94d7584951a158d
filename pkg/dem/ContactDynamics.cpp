#include "ContactDynamics.hpp"

#include <array>
#include <chrono>
#include <numeric>
#include <tuple>

#include <core/Interaction.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Omega.hpp>
#include <core/Scene.hpp>
#include <pkg/dem/NewtonIntegrator.hpp>

#include "AlertDistance.hpp"
#include "CdPhys.hpp"
#include "MissingFunctor.hpp"
#include "Rcr.hpp"
#include "RcrGeom.hpp"

namespace yade {

YADE_PLUGIN((ContactDynamics));
CREATE_LOGGER(ContactDynamics);

namespace {

	constexpr unsigned outOfPlane = State::DOF_Z | State::DOF_RX | State::DOF_RY;

	[[noreturn]] void refuse(const std::string& message) { throw std::invalid_argument("ContactDynamics: " + message); }

	std::string body(Body::id_t id) { return "body #" + std::to_string(id); }

	template <class EngineType> int place(const std::vector<shared_ptr<Engine>>& engines)
	{
		for (std::size_t k = 0; k < engines.size(); ++k)
			if (dynamic_cast<const EngineType*>(engines[k].get()) && !engines[k]->dead) return int(k);
		return -1;
	}

	std::string text(const Vector3r& v)
	{
		std::ostringstream out;
		out << '(' << v[0] << ", " << v[1] << ", " << v[2] << ')';
		return out.str();
	}

	void checkFinite(const Body& b, const char* what, const Vector3r& v, const char* remedy)
	{
		if (math::isfinite(v[0]) && math::isfinite(v[1]) && math::isfinite(v[2])) return;
		refuse(body(b.getId()) + " has the " + what + ' ' + text(v) + "; wanted finite numbers: " + remedy);
	}

	void checkBody(const Body& b, Scene& scene)
	{
		const State& s = *b.state;
		checkFinite(b, "position", s.pos, "set b.state.pos.");
		checkFinite(b, "velocity", s.vel, "set b.state.vel.");
		checkFinite(b, "angular velocity", s.angVel, "set b.state.angVel.");
		checkFinite(b, "force", scene.forces.getForce(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
		checkFinite(b, "torque", scene.forces.getTorque(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
		if (b.isClump() || b.isClumpMember())
			refuse(body(b.getId()) + " belongs to a clump; clumps are not served. Use single bodies, or a smooth law.");
		if (math::abs(s.ori.x()) > 1e-9 || math::abs(s.ori.y()) > 1e-9)
			refuse(body(b.getId()) + " is tilted out of the plane z = const; turn it about z only.");
		if (s.blockedDOFs == State::DOF_ALL) return;
		if ((s.blockedDOFs & outOfPlane) != outOfPlane)
			refuse(body(b.getId()) + " is free to leave the plane (blockedDOFs = '" + s.blockedDOFs_vec_get()
			       + "'); wanted z, X and Y blocked: b.state.blockedDOFs = 'zXY', as rcr.particle sets it.");
		const bool moves = (s.blockedDOFs & (State::DOF_X | State::DOF_Y)) != (State::DOF_X | State::DOF_Y);
		if (moves && !(s.mass > 0 && math::isfinite(s.mass)))
			refuse(body(b.getId()) + " is free but has the mass " + boost::lexical_cast<std::string>(s.mass)
			       + "; give it a mass > 0 or block its degrees of freedom.");
		if (!(s.blockedDOFs & State::DOF_RZ) && !(s.inertia[2] > 0 && math::isfinite(s.inertia[2])))
			refuse(body(b.getId()) + " is free to turn but has the moment of inertia " + boost::lexical_cast<std::string>(s.inertia[2])
			       + " about z; give it one > 0 or block Z.");
	}

	/// A pair that no Ig2 functor serves: YADE would let the two bodies pass through each other.
	void checkServed(const Interaction& i, const Scene& scene)
	{
		const Shape& shape1 = *(*scene.bodies)[i.getId1()]->shape;
		const Shape& shape2 = *(*scene.bodies)[i.getId2()]->shape;
		if (!dynamic_cast<const Rcr*>(&shape1) && !dynamic_cast<const Rcr*>(&shape2)) return;
		refuse("no Ig2 functor of the InteractionLoop serves " + shape1.getClassName() + " and " + shape2.getClassName() + " (bodies #"
		       + std::to_string(i.getId1()) + ", #" + std::to_string(i.getId2())
		       + "), so they would pass through each other. Add Ig2_Rcr_Rcr_RcrGeom, Ig2_Wall_Rcr_RcrGeom, Ig2_Box_Rcr_RcrGeom or "
		         "Ig2_Sphere_Rcr_RcrGeom; make other shapes from Wall, Box or Rcr.");
	}

	void checkPhys(const CdPhys& phys, Body::id_t id1, Body::id_t id2)
	{
		const bool friction = phys.tangensOfFrictionAngle >= 0, restitution = phys.restitution >= 0 && phys.restitution <= 1;
		if (friction && restitution) return;
		const std::string pair = "contact of bodies #" + std::to_string(id1) + " and #" + std::to_string(id2);
		if (!friction)
			refuse(pair + " has the friction coefficient " + boost::lexical_cast<std::string>(phys.tangensOfFrictionAngle)
			       + "; wanted a friction angle from 0 to below π/2.");
		refuse(pair + " has the restitution " + boost::lexical_cast<std::string>(phys.restitution) + "; wanted 0 to 1.");
	}

} // namespace

void ContactDynamics::action()
{
	if (!(scene->dt > 0 && math::isfinite(scene->dt)))
		refuse("O.dt = " + boost::lexical_cast<std::string>(scene->dt) + "; wanted a finite time step > 0.");
	if (!(correction >= 0 && correction <= 1))
		refuse("correction = " + boost::lexical_cast<std::string>(correction) + "; wanted a share of the overlap, 0 to 1.");
	const NewtonIntegrator& newton  = checkedIntegrator();
	const std::string       missing = missingFunctor(*scene);
	if (!missing.empty()) refuse(missing);
	scene->forces.sync();
	timed("check", [&] { checkBodies(); });
	iterations = 0;
	timed("gather", [&] { gatherBodies(newton); });
	for (int pass = 0; pass < 4; ++pass) {
		timed("gather", [&] { gatherContacts(); });
		timed("solve", [&] { report(rcr::solve(problem_, solver, settings(), workspace_)); });
		timed("scatter", [&] { keepForces(); });
		if (!lateContacts()) break;
	}
	timed("scatter", [&] {
		scatterForces();
		measureUnbalance();
	});
	timed("correct", [&] { correctPositions(); });
	late_.forget();
	keepColliderAhead();
}

template <class Work> void ContactDynamics::timed(const char* what, Work work)
{
	const auto start = std::chrono::steady_clock::now();
	work();
	seconds_[what] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

rcr::Settings ContactDynamics::settings() const
{
	rcr::Settings s;
	s.tolerance       = double(tolerance);
	s.maxIterations   = maxIterations;
	s.minIterations   = minIterations;
	s.violation       = double(maxViolation);
	s.meanForceChange = double(meanForceChange);
	s.threads         = solverThreads();
	return s;
}

void ContactDynamics::report(const rcr::Report& report)
{
	iterations += report.iterations;
	residual      = report.residual;
	violation     = report.violation;
	converged     = report.converged;
	contactPoints = int(problem_.points.size());
	if (converged || tolerance == 0 || warned) return;
	warned = true;
	LOG_WARN(
	        "step " << scene->iter << ": residual " << residual << " (tolerance " << tolerance << "), velocities still wrong by " << violation
	                << " of the typical one (at most " << maxViolation << "), after " << iterations
	                << " iterations; this is said once. ContactDynamics.residual and .converged tell it for every step.");
}

int ContactDynamics::solverThreads() const { return threads > 0 ? threads : omp_get_max_threads(); }

const NewtonIntegrator& ContactDynamics::checkedIntegrator() const
{
	if (scene->isPeriodic) refuse("O.periodic = True; periodic cells are not served. Bound the scene by walls.");
	const auto& engines    = scene->engines;
	const int   integrator = place<NewtonIntegrator>(engines), loop = place<InteractionLoop>(engines), self = place<ContactDynamics>(engines);
	if (integrator < 0) refuse("O.engines holds no NewtonIntegrator, so nothing would move; append NewtonIntegrator(damping=0).");
	if (loop < 0) refuse("O.engines holds no InteractionLoop, so there are no contacts; put one before ContactDynamics.");
	if (self < loop) refuse("stands before the InteractionLoop, so it would solve the contacts of the step before; put it after.");
	if (self > integrator) refuse("stands after the NewtonIntegrator, so its forces would come too late; put it before.");
	const auto& newton = static_cast<const NewtonIntegrator&>(*engines[integrator]);
	if (newton.damping != 0)
		refuse("NewtonIntegrator.damping = " + boost::lexical_cast<std::string>(newton.damping)
		       + " would damp the contact forces; set damping=0 (restitution below 1 dissipates by itself).");
	if (newton.densityScaling) refuse("NewtonIntegrator.densityScaling is on; switch it off, the time step is not bound by a stiffness.");
	return newton;
}

// All particles, whether they touch anything yet or not, and whatever of another shape they touch.
void ContactDynamics::checkBodies() const
{
	for (const auto& b : *scene->bodies) {
		if (!b || !b->shape) continue;
		const Rcr* particle = dynamic_cast<const Rcr*>(b->shape.get());
		if (particle && !(particle->capRadius > 0)) refuse(body(b->getId()) + " has a Rcr shape without a cap radius; set it.");
		if (particle) checkBody(*b, *scene);
	}
	for (const auto& i : *scene->interactions) {
		if (!i->isReal() || !dynamic_cast<const CdPhys*>(i->phys.get())) continue;
		const Body& first = *(*scene->bodies)[i->getId1()]; // Wall, Box and Sphere come first in their contacts
		if (!dynamic_cast<const Rcr*>(first.shape.get())) checkBody(first, *scene);
	}
}

void ContactDynamics::gatherBodies(const NewtonIntegrator& newton)
{
	const std::size_t n = scene->bodies->size();
	problem_.inverseMass.assign(n, {});
	problem_.freeVelocity.assign(n, {});
	const double dt = double(scene->dt);
	for (const auto& b : *scene->bodies) {
		if (!b) continue;
		if (newton.mask > 0 && !b->maskCompatible(newton.mask)) continue; // the integrator leaves it where it is
		const State&       s       = *b->state;
		const Body::id_t   id      = b->getId();
		const Vector3r     force   = scene->forces.getForce(id);
		const auto         free    = [&](unsigned dof) { return !(s.blockedDOFs & dof); };
		rcr::Twist&        v       = problem_.freeVelocity[id];
		rcr::InverseMass&  inverse = problem_.inverseMass[id];
		v                          = plane::twist(s);
		if (free(State::DOF_X)) {
			inverse.x = 1 / double(s.mass);
			v.x += dt * double(force[0] / s.mass + newton.gravity[0]);
		}
		if (free(State::DOF_Y)) {
			inverse.y = 1 / double(s.mass);
			v.y += dt * double(force[1] / s.mass + newton.gravity[1]);
		}
		if (free(State::DOF_RZ)) {
			inverse.rotation = 1 / double(s.inertia[2]);
			v.rotation += dt * double(scene->forces.getTorque(id)[2] / s.inertia[2]);
		}
	}
}

void ContactDynamics::findContacts()
{
	found_.clear();
	for (const auto& i : *scene->interactions) {
		if (i->isReal() && dynamic_cast<const CdPhys*>(i->phys.get())) found_.push_back({ i.get(), i->getId1(), i->getId2(), 0 });
		if (!i->functorCache.geomExists) checkServed(*i, *scene);
	}
	// The order of the container changes when a scene is reloaded; the order of the contacts must not. While the same
	// contacts come in the same order, so does what sorts them.
	const auto same = [](const Contact& a, const Contact& b) { return a.id1 == b.id1 && a.id2 == b.id2; };
	if (!std::equal(found_.begin(), found_.end(), lastFound_.begin(), lastFound_.end(), same)) {
		order_.resize(found_.size());
		std::iota(order_.begin(), order_.end(), 0);
		std::sort(order_.begin(), order_.end(), [this](int a, int b) {
			return std::tie(found_[a].id1, found_[a].id2) < std::tie(found_[b].id1, found_[b].id2);
		});
		lastFound_ = found_;
	}
	contacts_.clear();
	for (int k : order_)
		contacts_.push_back(found_[k]);
}

void ContactDynamics::gatherContacts()
{
	findContacts();
	frictionless_ = true;
	int points    = 0;
	for (Contact& contact : contacts_) {
		const CdPhys& phys = static_cast<const CdPhys&>(*contact.interaction->phys);
		checkPhys(phys, contact.id1, contact.id2);
		frictionless_ &= phys.tangensOfFrictionAngle == 0;
		contact.first = points;
		points += static_cast<const RcrGeom&>(*contact.interaction->geom).points;
	}
	problem_.points.resize(points);
	problem_.impulse.resize(points);
	const double dt = double(scene->dt);
#pragma omp parallel for schedule(static) num_threads(solverThreads())
	for (std::size_t i = 0; i < contacts_.size(); ++i) {
		const Contact&      contact  = contacts_[i];
		const CdPhys&       phys     = static_cast<const CdPhys&>(*contact.interaction->phys);
		const rcr::Manifold manifold = static_cast<const RcrGeom&>(*contact.interaction->geom).manifold();
		const rcr::Vec2     center1  = plane::toPlane((*scene->bodies)[contact.id1]->state->pos);
		const rcr::Vec2     center2  = plane::toPlane((*scene->bodies)[contact.id2]->state->pos);
		for (int k = 0; k < manifold.count; ++k) {
			const rcr::ManifoldPoint& at    = manifold.points[k];
			const Vector2r&           force = k == 0 ? phys.force1 : phys.force2;
			problem_.points[contact.first + k]
			        = { contact.id1,         contact.id2,           at.normal, at.position - center1, at.position - center2,
				    double(phys.bias[k]), double(phys.tangensOfFrictionAngle) };
			problem_.impulse[contact.first + k] = { dt * double(force[0]), dt * double(force[1]) };
		}
	}
	warmStart_ = problem_.impulse;
}

bool ContactDynamics::lateContacts()
{
	const InteractionLoop& loop = static_cast<const InteractionLoop&>(*scene->engines[place<InteractionLoop>(scene->engines)]);
	bool                   some = false;
	timed("late", [&] { some = late_.find(*scene, loop, problem_); });
	return some;
}

void ContactDynamics::keepForces()
{
	const double inverseDt = 1 / double(scene->dt);
#pragma omp parallel for schedule(static) num_threads(solverThreads())
	for (std::size_t i = 0; i < contacts_.size(); ++i) {
		const Contact& contact = contacts_[i];
		CdPhys&        phys    = static_cast<CdPhys&>(*contact.interaction->phys);
		rcr::Vec2      normal, shear;
		for (int k = 0; k < phys.points; ++k) {
			const rcr::Vec2     n = problem_.points[contact.first + k].normal;
			const rcr::Impulse& p = problem_.impulse[contact.first + k];
			(k == 0 ? phys.force1 : phys.force2) = Vector2r(inverseDt * p.n, inverseDt * p.t);
			normal                               = normal + (inverseDt * p.n) * n;
			shear                                = shear + (inverseDt * p.t) * perp(n);
		}
		phys.normalForce = plane::toSpace(normal);
		phys.shearForce  = plane::toSpace(shear);
	}
}

void ContactDynamics::scatterForces()
{
	const double inverseDt = 1 / double(scene->dt);
	for (std::size_t k = 0; k < problem_.points.size(); ++k) { // in one order, whatever the threads
		const rcr::ContactPoint& c = problem_.points[k];
		const rcr::Impulse&      p = problem_.impulse[k];
		const rcr::Vec2          f = inverseDt * (p.n * c.normal + p.t * perp(c.normal));
		scene->forces.addForceUnsynced(c.body1, -plane::toSpace(f));
		scene->forces.addForceUnsynced(c.body2, plane::toSpace(f));
		scene->forces.addTorqueUnsynced(c.body1, Vector3r(0, 0, -cross(c.arm1, f)));
		scene->forces.addTorqueUnsynced(c.body2, Vector3r(0, 0, cross(c.arm2, f)));
	}
}

void ContactDynamics::measureUnbalance()
{
	double contact = 0, net = 0, largest = 0; // impulses
	int    closed = 0, free = 0;
	for (const rcr::Impulse& p : problem_.impulse) {
		contact += p.n;
		closed += p.n > 0;
	}
	for (const auto& b : *scene->bodies) {
		if (!b || b->state->blockedDOFs == State::DOF_ALL) continue;
		const rcr::InverseMass& inverse = problem_.inverseMass[b->getId()];
		const rcr::Twist&       v       = problem_.velocity[b->getId()];
		const rcr::Twist        before  = plane::twist(*b->state);
		const double x = inverse.x > 0 ? (v.x - before.x) / inverse.x : 0, y = inverse.y > 0 ? (v.y - before.y) / inverse.y : 0;
		largest        = std::max(largest, std::hypot(x, y));
		net += std::hypot(x, y);
		++free;
	}
	constexpr double none = std::numeric_limits<double>::infinity();
	unbalance        = closed > 0 && free > 0 ? (net / free) / (contact / closed) : none;
	largestUnbalance = closed > 0 ? largest / (contact / closed) : none;
}

// Overlaps left by the tolerance of the solver, and by curvature within a step, are taken back by a displacement that is
// solved like a velocity but never becomes one: split impulses (Jourdan, Alart and Jean 1998), so no energy and no force.
//
//   displacement δ = dt v,  0 ≤ δ_n + g⁺ ⟂ ≥ 0 with g⁺ = g + dt u_n for the gap after the step
//
// and only the share `correction` of what an overlap has beyond the slop. Without a slop, contacts at rest would open and
// close for ever: each displacement opens some by what it closes others. A few sweeps must do, and what they leave is new
// overlap, so as long as no overlap exceeds the slop nothing is displaced.
void ContactDynamics::correctPositions()
{
	if (correction == 0) return;
	const double dt      = double(scene->dt);
	bool         overlap = false;
	shift_.points        = problem_.points;
	for (const Contact& contact : contacts_) {
		const RcrGeom& geom    = static_cast<const RcrGeom&>(*contact.interaction->geom);
		const double   allowed = RcrGeom::slop * double(geom.refR1 + geom.refR2);
		for (int k = 0; k < geom.points; ++k) {
			rcr::ContactPoint& c = shift_.points[contact.first + k];
			const double u       = relativeVelocity(c, problem_.velocity[c.body1], problem_.velocity[c.body2]).n;
			const double gap     = double(geom.gap[k]) + dt * u;
			overlap |= gap < -allowed;
			c.bias     = (gap < 0 ? double(correction) * std::min(gap + allowed, 0.0) : gap) / dt;
			c.friction = 0;
		}
	}
	if (!overlap) return;
	shift_.inverseMass = problem_.inverseMass;
	shift_.freeVelocity.assign(problem_.freeVelocity.size(), {});
	shift_.impulse.assign(problem_.impulse.size(), {});
	rcr::Settings few;
	few.tolerance     = 1e-2;
	few.maxIterations = 20;
	few.threads       = solverThreads();
	rcr::solveNesterov(shift_, few, shiftWorkspace_);
	for (const auto& b : *scene->bodies) {
		if (!b || b->state->blockedDOFs == State::DOF_ALL) continue;
		const rcr::Twist& shift = shift_.velocity[b->getId()];
		State&            s     = *b->state;
		s.pos += dt * Vector3r(shift.x, shift.y, 0);
		if (shift.rotation != 0) s.ori = (Quaternionr(AngleAxisr(dt * shift.rotation, Vector3r::UnitZ())) * s.ori).normalized();
	}
}

// The collider runs when a body has left its bounding box. It must also run when a body has become so fast that its alert
// distance, of which the box was made for an earlier speed, reaches out of it.
void ContactDynamics::keepColliderAhead() const
{
	const double dt = double(scene->dt);
	for (const auto& b : *scene->bodies) {
		if (!b || !b->bound) continue;
		const Rcr* particle = dynamic_cast<const Rcr*>(b->shape.get());
		if (!particle) continue;
		const rcr::Twist& v     = problem_.velocity[b->getId()];
		const double      reach = particle->circumscribedRadius() + alertDistance(*particle, v, dt);
		const Vector3r    moved = b->state->pos + dt * Vector3r(v.x, v.y, 0) - b->bound->refPos;
		const double      half  = 0.5 * double(b->bound->max[0] - b->bound->min[0]);
		if (std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > half) {
			scene->doSort = true;
			return;
		}
	}
}

boost::python::dict ContactDynamics::secondsDict() const
{
	boost::python::dict seconds;
	for (const auto& [what, total] : seconds_)
		seconds[what] = total;
	return seconds;
}

boost::python::dict ContactDynamics::problemDict() const
{
	namespace py = boost::python;
	py::dict   columns;
	const auto add = [&](const char* name, const auto& rows) {
		const char* bytes = reinterpret_cast<const char*>(rows.data());
		columns[name]     = py::object(py::handle<>(PyBytes_FromStringAndSize(bytes, Py_ssize_t(rows.size() * sizeof(rows[0])))));
	};
	std::vector<std::array<double, 8>> points; // normal, arm1, arm2, bias, friction
	std::vector<std::array<int, 2>>    bodies;
	for (const rcr::ContactPoint& c : problem_.points) {
		points.push_back({ c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias, c.friction });
		bodies.push_back({ c.body1, c.body2 });
	}
	add("points", points), add("bodies", bodies), add("impulse", warmStart_);
	add("inverse_mass", problem_.inverseMass), add("free_velocity", problem_.freeVelocity);
	return columns;
}

boost::python::dict ContactDynamics::modelDict() const
{
	boost::python::dict model;
	model["bodies"]       = problem_.inverseMass.size();
	model["pairs"]        = contacts_.size();
	model["points"]       = contactPoints;
	model["frictionless"] = frictionless_;
	return model;
}

} // namespace yade

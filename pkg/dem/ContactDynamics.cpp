#include "ContactDynamics.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <numeric>

#include <core/Interaction.hpp>
#include <core/Omega.hpp>
#include <core/Scene.hpp>

#include "../kernel/problem/coulomb.hpp"
#include "AlertDistance.hpp"
#include "CdPhys.hpp"
#include "RcrGeom.hpp"
#include "SceneCheck.hpp"
#include "prefetch.hpp"

namespace yade {

YADE_PLUGIN((ContactDynamics));
CREATE_LOGGER(ContactDynamics);

void ContactDynamics::action()
{
	if (!(correction >= 0 && correction <= 1))
		refuse("correction = " + boost::lexical_cast<std::string>(correction) + "; wanted a share of the overlap, 0 to 1.");
	const Engines engines = checkedEngines(*scene);
	scene->forces.sync();
	iterations = 0;
	work_      = 0;
	workspace_.team().run(solverThreads(), [&] { step(engines); });
	timed("gather", [&] { keepInteractionsTogether(); });
}

void ContactDynamics::step(const Engines& engines)
{
	constexpr int mostPasses = 10; // late contacts and long ways settle in two or three
	timed("gather", [&] { gatherBodies(engines.integrator); });
	timed("gather", [&] { gatherContacts(); });
	rcr::Settings how = settings();
	for (int pass = 1;; ++pass) {
		solve(how);
		timed("scatter", [&] { keepForces(); });
		bool late = false, again = false;
		if (pass < mostPasses) {
			timed("late", [&] { late = late_.find(*scene, engines.loop, bodies_, problem_); });
			timed("adapt", [&] { again = late || (!overdamped && adaptBiases(engines, pass <= mostPasses / 2)); });
		}
		if (!again) break;
		if (late) timed("gather", [&] { gatherContacts(); });
		how           = settingsOfFurtherPass();
		how.continued = !late;
		how.yielded   = yielded;
	}
	timed("scatter", [&] {
		scatterForces();
		measureUnbalance();
	});
	watch();
	timed("correct", [&] { correctPositions(); });
	timed("late", [&] {
		late_.forget();
		keepColliderAhead();
	});
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
	s.lanes           = lanes;
	s.compliance      = double(compliance);
	s.reductions      = rcr::Reductions::of(reductions);
	return s;
}

/// It mends a few contacts: too few to be seen in a residual of all, and next to them some sweeps are enough.
rcr::Settings ContactDynamics::settingsOfFurtherPass() const
{
	constexpr int some = 10;
	rcr::Settings s    = settings();
	s.minIterations    = std::max(s.minIterations, some);
	if (tolerance == 0) s.maxIterations = std::min(s.maxIterations, some);
	return s;
}

/// Colours and order are a key of their own.
void ContactDynamics::solve(const rcr::Settings& how)
{
	const double layout = workspace_.layoutSeconds();
	warmStart_          = problem_.impulse;
	timed("solve", [&] { report(rcr::solve(problem_, solver, how, workspace_)); });
	const double laidOut = workspace_.layoutSeconds() - layout;
	seconds_["layout"] += laidOut;
	seconds_["solve"] -= laidOut;
}

void ContactDynamics::report(const rcr::Report& report)
{
	iterations += report.iterations;
	work_ += report.work;
	residual      = report.residual;
	violation     = report.violation;
	converged     = report.converged;
	yielded       = report.yielded;
	contactPoints = int(problem_.points.size());
}

int ContactDynamics::solverThreads() const { return threads > 0 ? threads : omp_get_max_threads(); }

void ContactDynamics::gatherBodies(const NewtonIntegrator& newton)
{
	const std::size_t count = scene->bodies->size();
	problem_.inverseMass.resize(count);
	problem_.freeVelocity.resize(count);
	bodies_.resize(count);
	const BodyContainer& bodies = *scene->bodies;
	workspace_.team().forEach(count, [&](Body::id_t id) {
		if (id + 2 * prefetchAhead < count) {
			prefetch<Body>(bodies[id + 2 * prefetchAhead].get());
			prefetchBody(bodies[id + prefetchAhead].get());
		}
		problem_.inverseMass[id]  = {};
		problem_.freeVelocity[id] = {};
		bodies_[id]               = {};
		if (const Body* b = bodies[id].get()) gatherBody(*b, newton);
	});
}

namespace {

	/// Velocities that are not prescribed become zero.
	void stop(State& s)
	{
		for (int axis = 0; axis < 3; ++axis) {
			if (!(s.blockedDOFs & State::axisDOF(axis))) s.vel[axis] = 0;
			if (!(s.blockedDOFs & State::axisDOF(axis, true))) s.angVel[axis] = 0;
		}
	}

} // namespace

/// Checks all particles, whether they touch anything yet or not; others are checked with their contacts.
void ContactDynamics::gatherBody(const Body& b, const NewtonIntegrator& newton)
{
	const Body::id_t id       = b.getId();
	State&           s        = *b.state;
	const double     dt       = double(scene->dt);
	Rcr*             particle = dynamic_cast<Rcr*>(b.shape.get());
	if (particle) checkParticle(b, *particle, *scene);
	bodies_[id] = StepBody(b, particle, dt);
	if (newton.mask > 0 && !b.maskCompatible(newton.mask)) return; // the integrator leaves it where it is
	if (overdamped) {
		stop(s);
		bodies_[id].velocity = plane::twist(s);
	}
	const Vector3r    force   = scene->forces.getForce(id);
	const auto        free    = [&](unsigned dof) { return !(s.blockedDOFs & dof); };
	rcr::Twist&       v       = problem_.freeVelocity[id];
	rcr::InverseMass& inverse = problem_.inverseMass[id];
	v                         = bodies_[id].velocity;
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

/// Sorted by the ids, since the order of YADE's container changes when a scene is reloaded: counted into place by the first
/// id, then the few of one body by the second.
void ContactDynamics::findContacts()
{
	const InteractionContainer& interactions = *scene->interactions;
	found_.resize(scene->interactions->size());
	workspace_.team().forEach(found_.size(), [&](int k) {
		prefetchContact(interactions, found_.size(), k);
		found_[k] = contactOf(*interactions[k]);
	});
	firstOf_.assign(bodies_.size() + 1, 0);
	for (const Contact& contact : found_)
		if (contact.points > 0) ++firstOf_[contact.id1 + 1];
	std::partial_sum(firstOf_.begin(), firstOf_.end(), firstOf_.begin());
	contacts_.resize(firstOf_.back());
	next_ = firstOf_;
	for (const Contact& contact : found_)
		if (contact.points > 0) contacts_[next_[contact.id1]++] = contact;
	workspace_.team().forEach(bodies_.size(), [this](Body::id_t id) {
		const auto begin = contacts_.begin();
		std::sort(begin + firstOf_[id], begin + firstOf_[id + 1], [](const Contact& a, const Contact& b) { return a.id2 < b.id2; });
	});
	int points = 0;
	for (Contact& contact : contacts_) {
		contact.first = points;
		points += contact.points;
	}
	problem_.points.resize(points);
	problem_.impulse.resize(points);
	gap_.resize(points);
}

/// Without points where the interaction is none of ours.
ContactDynamics::Contact ContactDynamics::contactOf(Interaction& i) const
{
	const Body::id_t id1 = i.getId1(), id2 = i.getId2();
	if (!i.functorCache.geomExists) checkServed(i, *scene);
	if (!i.isReal()) return {};
	CdPhys* phys = dynamic_cast<CdPhys*>(i.phys.get());
	if (!phys) return {};
	if (!bodies_[id1].particle) checkBody(*(*scene->bodies)[id1], *scene); // Wall, Box and Sphere come first in their contacts
	RcrGeom* geom = static_cast<RcrGeom*>(i.geom.get());
	return { geom, phys, id1, id2, geom->points, 0 };
}

void ContactDynamics::gatherContacts()
{
	findContacts();
	const double dt = double(scene->dt);
	workspace_.team().forEach(contacts_.size(), [&](int i) {
		const Contact& contact = contacts_[i];
		const Contact& later   = contacts_[std::min(i + prefetchAhead, contacts_.size() - 1)];
		prefetch<RcrGeom>(later.geom);
		prefetch<CdPhys>(later.phys);
		const CdPhys&       phys     = *contact.phys;
		const RcrGeom&      geom     = *contact.geom;
		const rcr::Manifold manifold = geom.manifold();
		const rcr::Vec2     center1 = bodies_[contact.id1].center, center2 = bodies_[contact.id2].center;
		const double        friction = double(phys.tangensOfFrictionAngle);
		checkPhys(phys, contact.id1, contact.id2);
		for (int k = 0; k < contact.points; ++k) {
			const rcr::ManifoldPoint& at    = manifold.points[k];
			const Vector2r&           force = k == 0 ? phys.force1 : phys.force2;
			const int                 point = contact.first + k;
			const double              bias  = overdamped ? at.gap / dt : double(phys.bias[k]);
			problem_.points[point]  = { contact.id1, contact.id2, at.normal, at.position - center1, at.position - center2, bias, friction };
			problem_.impulse[point] = { dt * double(force[0]), dt * double(force[1]) };
			gap_[point]             = { at.gap, -RcrGeom::slop * double(geom.refR1 + geom.refR2) };
		}
	});
}

/// YADE's container is in the order in which interactions came and went. Where it is sorted by bodies, a body is still at hand when its
/// next interaction comes, here as in InteractionLoop, which takes a fifth to a third less time for 13 000 particles.
void ContactDynamics::keepInteractionsTogether()
{
	constexpr double most = 0.1; // share of contacts that may be out of order
	std::size_t      back = 0;
	Body::id_t       last = 0;
	for (const Contact& contact : found_) {
		if (contact.points == 0) continue;
		const Body::id_t id = std::min(contact.id1, contact.id2);
		back += id < last;
		last = id;
	}
	if (double(back) <= most * double(contacts_.size())) return;
	InteractionContainer&             all = *scene->interactions;
	const std::lock_guard<std::mutex> lock(all.drawloopmutex);
	const auto                        ids = [](const Interaction& i) { return std::minmax({ i.getId1(), i.getId2() }); };
	std::sort(all.begin(), all.begin() + all.size(), [&](const auto& a, const auto& b) { return ids(*a) < ids(*b); });
	for (std::size_t k = 0; k < all.size(); ++k)
		all[k]->linIx = k;
}

void ContactDynamics::keepForces()
{
	const double inverseDt = 1 / double(scene->dt);
	workspace_.team().forEach(contacts_.size(), [&](int i) {
		const Contact& contact = contacts_[i];
		CdPhys&        phys    = *contact.phys;
		prefetch<CdPhys>(contacts_[std::min(i + prefetchAhead, contacts_.size() - 1)].phys);
		rcr::Vec2      normal, shear;
		for (int k = 0; k < contact.points; ++k) {
			const rcr::Vec2     n = problem_.points[contact.first + k].normal;
			const rcr::Impulse& p = problem_.impulse[contact.first + k];
			(k == 0 ? phys.force1 : phys.force2) = Vector2r(inverseDt * p.n, inverseDt * p.t);
			normal                               = normal + (inverseDt * p.n) * n;
			shear                                = shear + (inverseDt * p.t) * perp(n);
		}
		phys.normalForce = plane::toSpace(normal);
		phys.shearForce  = plane::toSpace(shear);
	});
}

void ContactDynamics::scatterForces()
{
	load_.assign(bodies_.size(), {});
	for (std::size_t k = 0; k < problem_.points.size(); ++k) { // in one order, whatever the threads
		const rcr::ContactPoint& c    = problem_.points[k];
		const rcr::InverseMass   unit = { 1, 1, 1 };
		applyImpulse(c, problem_.impulse[k], unit, unit, load_[c.body1], load_[c.body2]);
	}
	const double inverseDt = 1 / double(scene->dt);
	workspace_.team().forEach(load_.size(), [&](Body::id_t id) {
		const rcr::Twist& load = load_[id];
		if (load.x == 0 && load.y == 0 && load.rotation == 0) return;
		scene->forces.addForceUnsynced(id, inverseDt * Vector3r(load.x, load.y, 0));
		scene->forces.addTorqueUnsynced(id, inverseDt * Vector3r(0, 0, load.rotation));
	});
}

void ContactDynamics::measureUnbalance()
{
	double contact = 0, net = 0, largest = 0; // impulses
	int    closed = 0, free = 0;
	for (const rcr::Impulse& p : problem_.impulse) {
		contact += p.n;
		closed += p.n > 0;
	}
	for (std::size_t id = 0; id < bodies_.size(); ++id) {
		if (!bodies_[id].free || !bodies_[id].particle) continue;
		const rcr::InverseMass& inverse = problem_.inverseMass[id];
		const rcr::Twist &      v = problem_.velocity[id], &before = bodies_[id].velocity;
		const rcr::Vec2         change { inverse.x > 0 ? (v.x - before.x) / inverse.x : 0, inverse.y > 0 ? (v.y - before.y) / inverse.y : 0 };
		largest = std::max(largest, norm(change));
		net += norm(change);
		++free;
	}
	constexpr double none = std::numeric_limits<double>::infinity();
	unbalance        = closed > 0 && free > 0 ? (net / free) / (contact / closed) : none;
	largestUnbalance = closed > 0 ? largest / (contact / closed) : none;
}

/// What a solved step shows to be wrong with its own biases; true if one has changed and the step is to be solved once more.
bool ContactDynamics::adaptBiases(const Engines& engines, bool letGo)
{
	bool changed = false;
	for (const Contact& contact : contacts_) {
		const int one = contact.id1, two = contact.id2;
		if (CurvedWays::isLong(bodies_[one], bodies_[two], problem_.velocity[one], problem_.velocity[two], double(scene->dt)))
			changed |= curved_.correct(*scene, engines.loop, bodies_, problem_, one, two, *contact.geom, *contact.phys, contact.first, letGo);
		const auto begin = problem_.points.begin() + contact.first;
		if (std::any_of(begin, begin + contact.points, [](const rcr::ContactPoint& c) { return c.bias < 0; })) changed |= restrainBounce(contact);
	}
	return changed;
}

/// Newton's rule returns the normal velocity whatever friction does meanwhile, and where the slip reverses it gives energy (Kane and
/// Levinson 1985). There the restitution is lowered to what keeps it.
bool ContactDynamics::restrainBounce(const Contact& contact)
{
	bool changed = false;
	for (int k = 0; k < contact.points && contact.phys->restitution > 0; ++k) {
		const rcr::ContactPoint& c = problem_.points[contact.first + k];
		if (!(c.bias < 0)) continue; // no bounce in this step
		const rcr::Impulse  before = relativeVelocity(c, bodies_[c.body1].velocity, bodies_[c.body2].velocity);
		const rcr::Impulse  after  = relativeVelocity(c, problem_.velocity[c.body1], problem_.velocity[c.body2]);
		const rcr::Delassus w      = rcr::delassus(c, problem_.inverseMass[c.body1], problem_.inverseMass[c.body2]);
		const double        share  = rcr::passiveShare(w, problem_.impulse[contact.first + k], before, after, c.bias, c.friction);
		contact.phys->bias[k] *= share;
		problem_.points[contact.first + k].bias = contact.phys->bias[k];
		changed |= share < 1;
	}
	return changed;
}

void ContactDynamics::watch()
{
	std::size_t deepest = 0;
	double      overlap = 0; // over R₁ + R₂
	for (std::size_t k = 0; k < gap_.size(); ++k) {
		const double share = RcrGeom::slop * gap_[k].now / gap_[k].allowed;
		if (share > overlap) overlap = share, deepest = k;
	}
	if (missedSteps_.count(!converged && tolerance > 0, yielded, overlap)) LOG_WARN("step " << scene->iter << ": " << missedSteps_.message());
	missedSteps    = int(missedSteps_.missed);
	yieldedSteps   = int(missedSteps_.yielded);
	deepestOverlap = missedSteps_.deepest;
	if (!squeeze_.goesOn(overlap)) return;
	std::string culprits;
	for (int id : rcr::drivenBodies(problem_))
		culprits += (culprits.empty() ? "#" : ", #") + std::to_string(id);
	if (culprits.empty()) return;
	const rcr::ContactPoint& c = problem_.points[deepest];
	std::ostringstream       text;
	text << "ContactDynamics: jam. Bodies #" << c.body1 << " and #" << c.body2 << " overlap by " << overlap << " of their radii, and more and more. Rigid grains do not give way; the motion prescribed to bodies "
	     << culprits << " asks for it. Stop or reverse that motion (b.state.vel), or press by a force (rcr.mobile_wall, WallStress).";
	throw std::runtime_error(text.str());
}

// Overlaps left by the tolerance of the solver, and by curvature within a step, are taken back by displacements that never
// become velocities (split impulses; Jourdan, Alart and Jean 1998): the step is solved once more from its own impulses, now
// with u_n ≥ β |g|/dt where g overlaps, and the bodies move by dt (v_β − v) besides. The loads of the step are in both, so
// contacts stay closed that a displacement alone would open, for the law to close them in the next step with a blow.
//
// Only what an overlap has beyond the slop counts; without a slop, contacts at rest would open and close for ever. In a
// marginal packing one contact opens only if others move much further, and by the square of that they overlap anew: the
// farthest shift is bounded, all others in proportion.
void ContactDynamics::correctPositions()
{
	constexpr double farthestShift = 1e-4; // of a radius
	constexpr int    sweeps        = 10; // 5 to 20 leave as little
	if (correction == 0 || overdamped) return;
	const double      dt = double(scene->dt);
	if (std::none_of(gap_.begin(), gap_.end(), [](const Gap& gap) { return gap.now < gap.allowed; })) return;
	shiftBias_.resize(gap_.size());
	workspace_.team().forEach(gap_.size(), [&](int k) {
		const double excess = gap_[k].now - gap_[k].allowed, bias = problem_.points[k].bias;
		shiftBias_[k] = excess < 0 ? std::min(bias, double(correction) * excess / dt) : bias;
	});
	rcr::sweepWithBias(problem_, shiftBias_, sweeps, shiftVelocity_, workspace_);
	const auto shift = [&](Body::id_t id) -> rcr::Twist {
		const rcr::Twist &v = problem_.velocity[id], &with = shiftVelocity_[id];
		return { dt * (with.x - v.x), dt * (with.y - v.y), dt * (with.rotation - v.rotation) };
	};
	double farthest = 0; // over the radius of a particle
	for (std::size_t id = 0; id < bodies_.size(); ++id)
		if (bodies_[id].free && bodies_[id].particle) farthest = std::max(farthest, plane::speed(shift(id), bodies_[id].radius) / bodies_[id].radius);
	const double share = std::min(1.0, farthestShift / farthest);
	workspace_.team().forEach(bodies_.size(), [&](Body::id_t id) {
		prefetch<State>(bodies_[std::min(id + prefetchAhead, bodies_.size() - 1)].state);
		if (!bodies_[id].free) return;
		const rcr::Twist by = shift(id);
		State&           s  = *bodies_[id].state;
		s.pos += share * Vector3r(by.x, by.y, 0);
		if (by.rotation != 0) s.ori = (Quaternionr(AngleAxisr(share * by.rotation, Vector3r::UnitZ())) * s.ori).normalized();
	});
}

// The collider runs when a body has left its bounding box. It must also run when a body has become so fast that its alert
// distance, of which the box was made for an earlier speed, reaches out of it.
void ContactDynamics::keepColliderAhead()
{
	const double      dt = double(scene->dt);
	std::atomic<bool> out { false };
	workspace_.team().forEach(bodies_.size(), [&](Body::id_t id) {
		const StepBody& b = bodies_[id];
		prefetch<Bound>(bodies_[std::min(id + prefetchAhead, bodies_.size() - 1)].bound);
		if (!b.particle || !b.bound) return;
		const rcr::Twist& v     = problem_.velocity[id];
		const double      reach = b.radius + alertDistance(*b.particle, v, dt);
		const Vector3r    moved = b.state->pos + dt * Vector3r(v.x, v.y, 0) - b.bound->refPos;
		const double      half  = 0.5 * double(b.bound->max[0] - b.bound->min[0]);
		if (std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > half) out.store(true, std::memory_order_relaxed);
	});
	if (out) scene->doSort = true;
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
	const rcr::ModelSummary m = workspace_.summary();
	boost::python::dict     model;
	model["bodies"]       = m.bodies;
	model["rotations"]    = m.turning;
	model["fixed"]        = m.fixed;
	model["pairs"]        = m.pairs;
	model["points"]       = m.points;
	model["unknowns"]     = m.unknowns();
	model["frictionless"] = m.frictionalPoints == 0;
	model["islands"]      = m.islands;
	model["layouts"]      = m.layouts;
	model["work"]         = work_;
	return model;
}

} // namespace yade

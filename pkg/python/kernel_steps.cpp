// Time steps of grains in NumPy arrays, without YADE.
#include "detection/pairs.hpp"
#include "kernel_arrays.hpp"
#include "passes/solve_step.hpp"
#include "problem/refuse.hpp"
#include "step/leapfrog.hpp"

namespace rcr {

namespace {

	class GrainSteps {
	public:
		GrainSteps(const Array& position, const Array& radius, const Array& inverseMass,
		        const py::object& halfLength, const py::object& angle, const py::object& velocity,
		        const std::vector<std::tuple<std::string, double, int>>& walls,
		        std::array<double, 2> gravity, const ContactLaw& law, const StepSettings& settings)
		        : gravity_ { gravity[0], gravity[1] }
		        , law_(law)
		        , settings_(settings)
		{
			const py::ssize_t count = rowsOf(position);
			const auto        given = [&](auto row, const py::object& array, const char* name) {
				using Row = decltype(row);
				return array.is_none() ? std::vector<Row>(count)
				                       : rowsFrom<Row>(array.cast<Array>(), name, count);
			};
			const auto at     = rowsFrom<Vec2>(position, "position", count);
			const auto cap    = rowsFrom<double>(radius, "radius", count);
			const auto half   = given(double(), halfLength, "half_length"),
			           turn   = given(double(), angle, "angle");
			const auto motion = given(PlanarVector(), velocity, "velocity");
			const auto mass   = rowsFrom<InverseMass>(inverseMass, "inverse_mass", count);
			for (py::ssize_t k = 0; k < count; ++k) {
				if (!(cap[k] > 0 && half[k] >= 0 && finite(cap[k], half[k])))
					refuse("grain ", k, ": radius ", cap[k], " and half_length ", half[k],
					        "; expected radius > 0 and half_length ≥ 0 [m]");
				if (!finite(at[k].x, at[k].y, turn[k], motion[k].x, motion[k].y, motion[k].rotation))
					refuse("grain ", k, ": position (", at[k].x, ", ", at[k].y, "), angle ", turn[k],
					        " and velocity (", motion[k].x, ", ", motion[k].y, ", ",
					        motion[k].rotation, "); expected finite numbers");
				add(stadiumShape(half[k], cap[k]), at[k], turned({}, turn[k]), motion[k], mass[k]);
			}
			for (const auto& [axis, place, sense] : walls) {
				if ((axis != "x" && axis != "y") || std::abs(sense) > 1 || !finite(place))
					refuse("a wall (", axis, ", ", place, ", ", sense,
					        "); expected ('x' or 'y', position [m], sense −1, 0 or 1)");
				PlanarShape shape;
				shape.kind = PlanarShape::wall;
				shape.axis = axis == "x" ? 0 : 1, shape.sense = std::int8_t(sense);
				add(shape, axis == "x" ? Vec2 { place, 0 } : Vec2 { 0, place }, {}, {}, {});
			}
			step_.problem.freeVelocity.resize(step_.bodies.size());
		}

		py::dict advance(double dt)
		{
			if (!(dt > 0 && finite(dt)))
				refuse("dt = ", dt, "; expected a time step > 0 [s]");
			step_.dt = dt;
			for (std::size_t id = 0; id < step_.bodies.size(); ++id) {
				StepBody& b     = step_.bodies[id];
				b.alertDistance = alertDistance(b.shape, b.velocity, dt);
				if (b.free) b.coveredPath = b.alertDistance;
				beginStep(step_, id, b.velocity, inertia(id), {}, gravity_);
			}
			ThreadTeam& team = workspace_.team();
			StepResult  result;
			team.run(1, [&] {
				const StepHost host { [](int, int) { return true; },
					[&](int, int) { return law_; } };
				pairs_.detect({ neighbors_, team, host.allows }, step_, host, 0);
				pairs_.fillStep(step_, team);
				result = solveStep(step_, settings_, host, neighbors_, workspace_);
				pairs_.store(step_, team, 0);
			});
			move();
			py::dict out;
			out["converged"]      = result.converged;
			out["residual"]       = result.residual;
			out["error_estimate"] = result.errorEstimate;
			out["iterations"]     = result.iterations;
			out["yielded"]        = result.yielded;
			return out;
		}

		Array position() const
		{
			return rows<Vec2>([](const StepBody& b) { return b.center; });
		}
		Array angle() const
		{
			return rows<double>([](const StepBody& b) {
				return 2 * std::atan2(b.turn.z, b.turn.w);
			});
		}
		Array velocity() const
		{
			return rows<PlanarVector>([](const StepBody& b) { return b.velocity; });
		}
		/// The contact points of the last step.
		py::dict contacts() const
		{
			std::vector<Vec2>         normal, force;
			std::vector<double>       gap, moment;
			std::vector<std::int32_t> bodies;
			for (const StepContact& c : step_.contacts)
				for (int k = c.first; k < c.first + c.count; ++k) {
					bodies.insert(bodies.end(), { c.body1, c.body2 });
					normal.push_back(step_.problem.points[k].normal);
					force.push_back({ step_.force[k].n, step_.force[k].t });
					gap.push_back(step_.gap[k].atStart);
					moment.push_back(step_.rollingMoment[k]);
				}
			py::dict out;
			out["bodies"]
			        = Ids({ py::ssize_t(gap.size()), py::ssize_t(2) }, bodies.data());
			out["normal"] = arrayOf(normal), out["force"] = arrayOf(force);
			out["gap"] = py::array_t<double>(py::ssize_t(gap.size()), gap.data());
			out["rolling_moment"]
			        = py::array_t<double>(py::ssize_t(gap.size()), moment.data());
			return out;
		}

	private:
		void add(const PlanarShape& shape, Vec2 center, Turn turn, PlanarVector velocity,
		        const InverseMass& mass)
		{
			StepBody body;
			body.shape = shape, body.center = center, body.turn = turn, body.velocity = velocity;
			body.radius = shape.radius();
			body.owner  = int(step_.bodies.size());
			body.free   = shape.grain() && !mass.prescribed();
			step_.bodies.push_back(body);
			step_.problem.inverseMass.push_back(mass);
		}
		Inertia inertia(std::size_t id) const
		{
			const InverseMass& m      = step_.problem.inverseMass[id];
			const double       moment = m.rotation > 0 ? 1 / m.rotation : 0;
			return { m.mass(), moment, m.x > 0, m.y > 0, m.rotation > 0 };
		}
		/// Displaces the bodies and moves them by their velocities.
		void move()
		{
			for (std::size_t id = 0; id < step_.bodies.size(); ++id) {
				StepBody& b = step_.bodies[id];
				b.velocity  = step_.problem.velocity[id];
				if (!finite(b.velocity.x, b.velocity.y, b.velocity.rotation))
					refuse("the step gives body ", id, " the velocity (", b.velocity.x, ", ",
					        b.velocity.y, ", ", b.velocity.rotation,
					        "); find the extreme mass, velocity or load among the arguments");
				if (!step_.displacement.empty() && b.free) displace(b, step_.displacement[id]);
				rcr::move(b, step_.dt);
			}
		}
		template <class Row, class Of> Array rows(Of of) const
		{
			std::vector<Row> all;
			for (const StepBody& b : step_.bodies)
				if (b.shape.grain()) all.push_back(of(b));
			Array array = arrayOf(all);
			return sizeof(Row) == sizeof(double)
			        ? Array(array.reshape({ py::ssize_t(all.size()) }))
			        : array;
		}

		Vec2                     gravity_;
		ContactLaw               law_;
		StepSettings             settings_;
		Step                     step_;
		Neighbors                neighbors_;
		Pairs                    pairs_;
		Workspace                workspace_;
	};

} // namespace

void bindSteps(py::module_& m)
{
	py::class_<GrainSteps>(
	        m, "GrainSteps",
	        "Grains between walls that move by Contact Dynamics, in arrays, without YADE.\n"
	        "\n"
	        "Grains are discs of `radius` or, with `half_length` > 0, rounded-cap rectangles.\n"
	        "Lengths in m, times in s; masses and forces per unit depth.\n"
	        "\n"
	        "Arrays: position (n, 2), radius (n,), inverse_mass (n, 3) as (1/m, 1/m, 1/I), where 0\n"
	        "prescribes the motion; optional half_length and angle (n,), velocity (n, 3).\n"
	        "walls: list of (axis 'x' or 'y', position, sense −1, 0 or 1); gravity (2,) [m/s²].\n"
	        "Of all contacts: friction, restitution, adhesion [N], rolling_friction.\n"
	        "solver, tolerance, accuracy and max_iterations are those of ContactDynamics.\n"
	        "Raises ValueError for wrong shapes and numbers.")
	        .def(py::init([](const Array& position, const Array& radius,
	                         const Array& inverseMass, const py::object& halfLength,
	                         const py::object& angle, const py::object& velocity,
	                         const std::vector<std::tuple<std::string, double, int>>& walls,
	                         std::array<double, 2> gravity, double friction, double restitution,
	                         double adhesion, double rollingFriction, const std::string& solver,
	                         double tolerance, double accuracy, int maxIterations) {
		             StepSettings settings;
		             settings.solver             = solver;
		             settings.pass.tolerance     = tolerance;
		             settings.pass.accuracy      = accuracy;
		             settings.pass.maxIterations = maxIterations;
		             checkSettings(solver, settings.pass);
		             if (!(restitution >= 0 && restitution <= 1))
			             refuse("restitution = ", restitution, "; expected 0 to 1");
		             for (double one : { friction, adhesion, rollingFriction })
			             if (!(one >= 0 && one <= std::numeric_limits<double>::max()))
				             refuse("friction, adhesion or rolling_friction = ",
				                    one, "; expected a finite number ≥ 0");
		             return new GrainSteps(
		                     position, radius, inverseMass, halfLength, angle, velocity,
		                     walls, gravity,
		                     { friction, restitution, adhesion, rollingFriction },
		                     settings);
	             }),
	             "position"_a, "radius"_a, "inverse_mass"_a, "half_length"_a = py::none(),
	             "angle"_a = py::none(), "velocity"_a = py::none(),
	             "walls"_a   = std::vector<std::tuple<std::string, double, int>>(),
	             "gravity"_a = std::array<double, 2> { 0, 0 }, "friction"_a = 0,
	             "restitution"_a = 0, "adhesion"_a = 0, "rolling_friction"_a = 0,
	             "solver"_a = "auto", "tolerance"_a = 1e-4, "accuracy"_a = 0.01,
	             "max_iterations"_a = 1000)
	        .def("step", &GrainSteps::advance, "dt"_a,
	             "Takes a step [s]. Returns a dict: converged, residual, error_estimate [-],\n"
	             "iterations, yielded.")
	        .def_property_readonly("position", &GrainSteps::position, "Centres (n, 2) [m].")
	        .def_property_readonly("angle", &GrainSteps::angle, "Orientations (n,) [rad].")
	        .def_property_readonly(
	                "velocity", &GrainSteps::velocity, "(v_x, v_y, ω), (n, 3) [m/s, 1/s].")
	        .def("contacts", &GrainSteps::contacts,
	             "Contact points of the last step, a dict of arrays: bodies (nc, 2), where walls\n"
	             "follow the grains; normal (nc, 2) from body 1 to body 2; force (nc, 2) as (n, t)\n"
	             "on body 2 [N]; gap at the beginning (nc,) [m]; rolling_moment on body 2 (nc,)\n"
	             "[N m].");
}

} // namespace rcr

// Bindings of stadium, shadow overlap and deposition.
#include <cmath>
#include <sstream>

#include "geometry/deposition.hpp"
#include "geometry/shadow_overlap.hpp"
#include "kernel_arrays.hpp"

namespace rcr {

namespace {

	py::dict toDict(const std::vector<Manifold>& manifolds)
	{
		const py::ssize_t n = manifolds.size();
		Ids               count(n), type(n);
		Array             position({ n, py::ssize_t(2), py::ssize_t(2) }),
		        normal({ n, py::ssize_t(2), py::ssize_t(2) });
		Array gap({ n, py::ssize_t(2) });
		for (py::ssize_t i = 0; i < n; ++i) {
			count.mutable_at(i) = manifolds[i].count;
			type.mutable_at(i)  = int(manifolds[i].type);
			for (int k = 0; k < 2; ++k) {
				const ManifoldPoint& p       = manifolds[i].points[k];
				const bool           used    = k < manifolds[i].count;
				position.mutable_at(i, k, 0) = used ? p.position.x : NAN;
				position.mutable_at(i, k, 1) = used ? p.position.y : NAN;
				normal.mutable_at(i, k, 0)   = used ? p.normal.x : NAN;
				normal.mutable_at(i, k, 1)   = used ? p.normal.y : NAN;
				gap.mutable_at(i, k)         = used ? p.gap : NAN;
			}
		}
		return py::dict(
		        py::arg("count") = count, py::arg("type") = type, py::arg("position") = position,
		        py::arg("normal") = normal, py::arg("gap") = gap);
	}

	Pose poseAt(const Array& a, py::ssize_t i)
	{
		return pose({ a.at(i, 0), a.at(i, 1) }, a.at(i, 2));
	}
	Stadium stadiumAt(const Array& a, py::ssize_t i) { return { a.at(i, 0), a.at(i, 1) }; }

	py::dict overlapStadiums(
	        const Array& stadium1, const Array& pose1, const Array& stadium2, const Array& pose2,
	        double alertDistance)
	{
		const py::ssize_t n = stadium1.ndim() ? stadium1.shape(0) : 0;
		requireShape(stadium1, "stadium1", n, 2);
		requireShape(pose1, "pose1", n, 3);
		requireShape(stadium2, "stadium2", n, 2);
		requireShape(pose2, "pose2", n, 3);
		std::vector<Manifold> result(n);
		for (py::ssize_t i = 0; i < n; ++i)
			result[i] = shadowOverlap(
			        stadiumAt(stadium1, i), poseAt(pose1, i), stadiumAt(stadium2, i),
			        poseAt(pose2, i), alertDistance);
		return toDict(result);
	}

	py::dict overlapWall(
	        const Array& origin, const Array& normal, const Array& stadium, const Array& at,
	        double alertDistance)
	{
		const py::ssize_t n = stadium.ndim() ? stadium.shape(0) : 0;
		requireShape(origin, "origin", n, 2);
		requireShape(normal, "normal", n, 2);
		requireShape(stadium, "stadium", n, 2);
		requireShape(at, "pose", n, 3);
		std::vector<Manifold> result(n);
		for (py::ssize_t i = 0; i < n; ++i) {
			const HalfPlane wall { { origin.at(i, 0), origin.at(i, 1) },
				                   { normal.at(i, 0), normal.at(i, 1) } };
			result[i] = shadowOverlap(wall, stadiumAt(stadium, i), poseAt(at, i), alertDistance);
		}
		return toDict(result);
	}

	py::dict overlapBox(
	        const Array& halfExtent, const Array& boxPose, const Array& stadium, const Array& at,
	        double alertDistance)
	{
		const py::ssize_t n = stadium.ndim() ? stadium.shape(0) : 0;
		requireShape(halfExtent, "half_extent", n, 2);
		requireShape(boxPose, "box_pose", n, 3);
		requireShape(stadium, "stadium", n, 2);
		requireShape(at, "pose", n, 3);
		std::vector<Manifold> result(n);
		for (py::ssize_t i = 0; i < n; ++i)
			result[i] = shadowOverlap(
			        Rectangle { { halfExtent.at(i, 0), halfExtent.at(i, 1) } }, poseAt(boxPose, i),
			        stadiumAt(stadium, i), poseAt(at, i), alertDistance);
		return toDict(result);
	}

	Array depositArrays(const Array& radii, double width)
	{
		const py::ssize_t n = radii.ndim() ? radii.shape(0) : 0;
		requireShape(radii, "radii", n, 1);
		for (py::ssize_t i = 0; i < n; ++i)
			if (!(radii.at(i) > 0 && 2 * radii.at(i) <= width && std::isfinite(width))) {
				std::ostringstream message;
				message << "radii[" << i << "] = " << radii.at(i) << " in a box of width " << width
				        << "; expected 0 < 2 radius <= width";
				throw py::value_error(message.str());
			}
		const std::vector<Vec2> centers = deposit({ radii.data(), radii.data() + n }, width);
		Array                   result({ n, py::ssize_t(2) });
		for (py::ssize_t i = 0; i < n; ++i)
			result.mutable_at(i, 0) = centers[i].x, result.mutable_at(i, 1) = centers[i].y;
		return result;
	}

} // namespace

void bindGeometry(py::module_& m)
{
	m.def(
	        "area",
	        [](double a, double r) {
		        return area(Stadium { a, r });
	        },
	        py::arg("half_length"), py::arg("cap_radius"), "Area of a stadium [m²].");
	m.def(
	        "polar_moment",
	        [](double a, double r) {
		        return polarMoment(Stadium { a, r });
	        },
	        py::arg("half_length"), py::arg("cap_radius"),
	        "∫ |x|² dA of a stadium about its centre [m⁴].");
	m.def(
	        "half_extent",
	        [](double a, double r, double angle) {
		        const Vec2 h = halfExtent(Stadium { a, r }, pose({}, angle).axis);
		        return py::make_tuple(h.x, h.y);
	        },
	        py::arg("half_length"), py::arg("cap_radius"), py::arg("angle"),
	        "Half widths of the axis-aligned bounding box [m].");

	const char* manifold
	        = "Manifolds of N pairs: dict of count (N,), type (N,) with 0 cc, 1 cs, 2 ss, 3 wall,\n"
	          "position and normal (N, 2, 2), gap (N, 2) [m]. Unused points are NaN. A stadium is\n"
	          "(half length, cap radius), a pose (x, y, angle).";
	m.def("overlap_stadiums", overlapStadiums, py::arg("stadium1"), py::arg("pose1"),
	      py::arg("stadium2"), py::arg("pose2"), py::arg("alert_distance"), manifold);
	m.def("overlap_wall", overlapWall, py::arg("origin"), py::arg("normal"), py::arg("stadium"),
	      py::arg("pose"), py::arg("alert_distance"), manifold);
	m.def("overlap_box", overlapBox, py::arg("half_extent"), py::arg("box_pose"),
	      py::arg("stadium"), py::arg("pose"), py::arg("alert_distance"), manifold);

	m.def("deposit", depositArrays, py::arg("radii"), py::arg("width"),
	      "Centres (n, 2) [m] of discs deposited one by one, each at the lowest free\n"
	      "position in the box 0 <= x <= width, y >= 0.");
}

} // namespace rcr

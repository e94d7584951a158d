// Bindings of stadium, shadow overlap and deposition.
#include <array>
#include <sstream>

#include "geometry/deposition.hpp"
#include "geometry/shadow_overlap.hpp"
#include "kernel_arrays.hpp"

namespace rcr {

namespace {

	/// Manifolds of n pairs as arrays; `overlap` returns that of pair i.
	template <class Overlap> py::dict manifolds(py::ssize_t n, Overlap overlap)
	{
		Ids   count(n), type(n);
		Array position({ n, py::ssize_t(2), py::ssize_t(2) }),
		        normal({ n, py::ssize_t(2), py::ssize_t(2) });
		Array gap({ n, py::ssize_t(2) });
		for (py::ssize_t i = 0; i < n; ++i) {
			const Manifold manifold = overlap(i);
			count.mutable_at(i)     = manifold.count;
			type.mutable_at(i)      = int(manifold.type);
			for (int k = 0; k < 2; ++k) {
				const ManifoldPoint& p       = manifold.points[k];
				const bool           used    = k < manifold.count;
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

	/// Poses from rows (x, y, angle).
	std::vector<Pose> posesFrom(const Array& array, const char* name, py::ssize_t count)
	{
		std::vector<Pose> poses;
		for (const auto& [x, y, angle] : rowsFrom<std::array<double, 3>>(array, name, count))
			poses.push_back(pose({ x, y }, angle));
		return poses;
	}

	py::dict overlapStadiums(const Array& stadium1, const Array& pose1, const Array& stadium2,
	        const Array& pose2, double maxGap)
	{
		const py::ssize_t n      = rowsOf(stadium1);
		const auto        shape1 = rowsFrom<Stadium>(stadium1, "stadium1", n);
		const auto        at1    = posesFrom(pose1, "pose1", n);
		const auto        shape2 = rowsFrom<Stadium>(stadium2, "stadium2", n);
		const auto        at2    = posesFrom(pose2, "pose2", n);
		return manifolds(n, [&](py::ssize_t i) {
			return shadowOverlap(shape1[i], at1[i], shape2[i], at2[i], maxGap);
		});
	}

	py::dict overlapWall(const Array& origin, const Array& normal, const Array& stadium,
	        const Array& pose, double maxGap)
	{
		const py::ssize_t n       = rowsOf(stadium);
		const auto        origins = rowsFrom<Vec2>(origin, "origin", n);
		const auto        normals = rowsFrom<Vec2>(normal, "normal", n);
		const auto        shapes  = rowsFrom<Stadium>(stadium, "stadium", n);
		const auto        poses   = posesFrom(pose, "pose", n);
		return manifolds(n, [&](py::ssize_t i) {
			const HalfPlane wall { origins[i], normals[i] };
			return shadowOverlap(wall, shapes[i], poses[i], maxGap);
		});
	}

	py::dict overlapBox(const Array& halfExtent, const Array& boxPose, const Array& stadium,
	        const Array& pose, double maxGap)
	{
		const py::ssize_t n        = rowsOf(stadium);
		const auto        boxes    = rowsFrom<Rectangle>(halfExtent, "half_extent", n);
		const auto        boxPoses = posesFrom(boxPose, "box_pose", n);
		const auto        shapes   = rowsFrom<Stadium>(stadium, "stadium", n);
		const auto        poses    = posesFrom(pose, "pose", n);
		return manifolds(n, [&](py::ssize_t i) {
			return shadowOverlap(boxes[i], boxPoses[i], shapes[i], poses[i], maxGap);
		});
	}

	Array depositArrays(const Array& radii, double width)
	{
		const auto rows = rowsFrom<double>(radii, "radii", rowsOf(radii));
		for (std::size_t i = 0; i < rows.size(); ++i)
			if (!(rows[i] > 0 && 2 * rows[i] <= width && std::isfinite(width))) {
				std::ostringstream message;
				message << "radii[" << i << "] = " << rows[i] << " in a box of width " << width
				        << "; expected 0 < 2 radius <= width";
				throw py::value_error(message.str());
			}
		return arrayOf(deposit(rows, width));
	}

} // namespace

void bindGeometry(py::module_& m)
{
	m.def(
	        "area", [](double a, double r) { return area(Stadium { a, r }); },
	        py::arg("half_length"), py::arg("cap_radius"), "Area of a stadium [m²].");
	m.def(
	        "polar_moment", [](double a, double r) { return polarMoment(Stadium { a, r }); },
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
	      py::arg("stadium2"), py::arg("pose2"), py::arg("max_gap"), manifold);
	m.def("overlap_wall", overlapWall, py::arg("origin"), py::arg("normal"), py::arg("stadium"),
	      py::arg("pose"), py::arg("max_gap"), manifold);
	m.def("overlap_box", overlapBox, py::arg("half_extent"), py::arg("box_pose"),
	      py::arg("stadium"), py::arg("pose"), py::arg("max_gap"), manifold);

	m.def("deposit", depositArrays, py::arg("radii"), py::arg("width"),
	      "Centres (n, 2) [m] of discs deposited one by one, each at the lowest free\n"
	      "position in the box 0 <= x <= width, y >= 0.");
}

} // namespace rcr

// Bindings of shapes, shadow overlap and deposition.
#include <array>

#include "geometry/deposition.hpp"
#include "geometry/planar_shape.hpp"
#include "kernel_arrays.hpp"
#include "problem/refuse.hpp"

namespace rcr {

namespace {

	/// Manifolds of n pairs as arrays; `overlap` returns that of pair i.
	template <class Overlap> py::dict manifolds(py::ssize_t n, Overlap overlap)
	{
		Ids   count(n), type(n);
		const py::ssize_t two = 2;
		Array position({ n, two, two }), normal({ n, two, two }), gap({ n, two });
		Array shadow(n), slope(n);
		Ids   slide(n);
		for (py::ssize_t i = 0; i < n; ++i) {
			Manifold manifold   = overlap(i);
			count.mutable_at(i) = manifold.count;
			type.mutable_at(i)  = int(manifold.type);
			shadow.mutable_at(i) = manifold.shadow;
			slide.mutable_at(i)  = manifold.slide;
			slope.mutable_at(i)  = manifold.slope;
			for (int k = 0; k < 2; ++k) {
				ManifoldPoint& p = manifold.points[k];
				if (k >= manifold.count) p = { { NAN, NAN }, { NAN, NAN }, NAN };
				position.mutable_at(i, k, 0) = p.position.x;
				position.mutable_at(i, k, 1) = p.position.y;
				normal.mutable_at(i, k, 0)   = p.normal.x;
				normal.mutable_at(i, k, 1)   = p.normal.y;
				gap.mutable_at(i, k)         = p.gap;
			}
		}
		return py::dict("count"_a = count, "type"_a = type, "position"_a = position,
		        "normal"_a = normal, "gap"_a = gap, "shadow"_a = shadow, "slide"_a = slide,
		        "slope"_a = slope);
	}

	Vec2 axisOf(double angle) { return { std::cos(angle), std::sin(angle) }; }

	/// Poses from rows (x, y, angle).
	std::vector<Pose> posesFrom(const Array& array, const char* name, py::ssize_t count)
	{
		std::vector<Pose> poses;
		for (const auto& [x, y, angle] : rowsFrom<std::array<double, 3>>(array, name, count))
			poses.push_back({ { x, y }, axisOf(angle) });
		return poses;
	}

	PlanarShape shapeOf(const Stadium& s) { return stadiumShape(s.halfLength, s.capRadius); }
	PlanarShape shapeOf(Vec2 halfExtent) { return boxShape(halfExtent); }

	std::vector<Vec2> checkedCore(const Array& vertices, double rounding)
	{
		auto              core  = rowsFrom<Vec2>(vertices, "vertices", rowsOf(vertices));
		const std::string error = polygonError(core, rounding);
		if (!error.empty()) refuse(error);
		return core;
	}

	PlanarShape polygonShape(const Array& vertices, double rounding)
	{
		PlanarShape shape;
		shape.kind     = PlanarShape::polygon;
		shape.rounding = rounding;
		setCore(shape, checkedCore(vertices, rounding));
		return shape;
	}

	/// Manifolds of two shapes at many poses.
	py::dict overlapPolygons(const Array& vertices1, double radius1, const Array& pose1,
	        const Array& vertices2, double radius2, const Array& pose2, double maxGap)
	{
		const PlanarShape one = polygonShape(vertices1, radius1), two = polygonShape(vertices2, radius2);
		const py::ssize_t n = rowsOf(pose1);
		const auto at1 = posesFrom(pose1, "pose1", n), at2 = posesFrom(pose2, "pose2", n);
		return manifolds(
		        n, [&](py::ssize_t i) { return contactPoints(one, at1[i], two, at2[i], maxGap); });
	}

	/// Manifolds of the half plane y ≤ 0 and a rounded polygon at many poses.
	py::dict overlapFloor(
	        const Array& vertices, double radius, const Array& pose, double maxGap)
	{
		PlanarShape floor;
		floor.kind = PlanarShape::wall, floor.axis = 1, floor.sense = 1;
		const PlanarShape polygon = polygonShape(vertices, radius);
		const py::ssize_t n       = rowsOf(pose);
		const auto        at      = posesFrom(pose, "pose", n);
		return manifolds(
		        n, [&](py::ssize_t i) { return contactPoints(floor, {}, polygon, at[i], maxGap); });
	}

	/// Binds the manifolds of bodies of shape One and stadia; `names`: of both shapes and poses.
	template <class One>
	void bindOverlap(py::module_& m, const char* function, const std::array<const char*, 4>& names,
	        const char* text)
	{
		const auto overlap = [names](const Array& one, const Array& pose1, const Array& two,
		                             const Array& pose2, double maxGap) {
			const py::ssize_t n      = rowsOf(two);
			const auto        shape1 = rowsFrom<One>(one, names[0], n);
			const auto        at1    = posesFrom(pose1, names[1], n);
			const auto        shape2 = rowsFrom<Stadium>(two, names[2], n);
			const auto        at2    = posesFrom(pose2, names[3], n);
			return manifolds(n, [&](py::ssize_t i) {
				return contactPoints(
				        shapeOf(shape1[i]), at1[i], shapeOf(shape2[i]), at2[i], maxGap);
			});
		};
		m.def(function, overlap, py::arg(names[0]), py::arg(names[1]), py::arg(names[2]),
		        py::arg(names[3]), "max_gap"_a, text);
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

	Array depositArrays(const Array& radii, double width)
	{
		const auto rows = rowsFrom<double>(radii, "radii", rowsOf(radii));
		for (std::size_t i = 0; i < rows.size(); ++i)
			if (!(rows[i] > 0 && 2 * rows[i] <= width && std::isfinite(width)))
				refuse("radii[", i, "] = ", rows[i], " in a box of width ", width,
				        "; expected 0 < 2 radius <= width");
		return arrayOf(deposit(rows, width));
	}

} // namespace

void bindGeometry(py::module_& m)
{
	m.def("area", [](double a, double r) { return area(Stadium { a, r }); }, "half_length"_a,
	        "cap_radius"_a, "Area of a stadium [m²].");
	m.def("polar_moment", [](double a, double r) { return polarMoment(Stadium { a, r }); },
	        "half_length"_a, "cap_radius"_a, "∫ |x|² dA of a stadium about its centre [m⁴].");
	m.def(
	        "half_extent",
	        [](double a, double r, double angle) {
		        const Vec2 h = halfExtent(Stadium { a, r }, axisOf(angle));
		        return py::make_tuple(h.x, h.y);
	        },
	        "half_length"_a, "cap_radius"_a, "angle"_a,
	        "Half widths of the axis-aligned bounding box [m].");
	const char* manifold
	        = "Manifolds of N pairs: dict of count (N,), type (N,) with 0 cc, 1 cs, 2 ss, 3\n"
	          "obstacle, position and normal (N, 2, 2), gap (N, 2) [m]. Unused points are NaN.\n"
	          "shadow (N,) is the length of the shadow [m]; slide (N,) and slope (N,) are its change\n"
	          "and that of the shallower gap per tangential displacement of body 2. A stadium is\n"
	          "(half length, cap radius), a pose (x, y, angle).";
	bindOverlap<Stadium>(
	        m, "overlap_stadiums", { "stadium1", "pose1", "stadium2", "pose2" }, manifold);
	bindOverlap<Vec2>(
	        m, "overlap_box", { "half_extent", "box_pose", "stadium", "pose" }, manifold);
	m.def("overlap_polygons", overlapPolygons, "vertices1"_a, "radius1"_a, "pose1"_a, "vertices2"_a,
	        "radius2"_a, "pose2"_a, "max_gap"_a,
	        "Manifolds of two rounded polygons at N poses (N, 3), as overlap_stadiums returns them.\n"
	        "Vertices (n, 2) are in the frames of the poses [m].");
	m.def(
	        "polygon_moments",
	        [](const Array& vertices, double rounding) {
		        const auto [area, c, moment] = momentsOf(checkedCore(vertices, rounding), rounding);
		        return py::make_tuple(area, py::make_tuple(c.x, c.y), moment);
	        },
	        "vertices"_a, "radius"_a,
	        "Area [m²], centroid [m] and ∫ |x − centroid|² dA [m⁴] of a rounded polygon. A\n"
	        "ValueError says what is wrong with its vertices (n, 2) [m] or its rounding radius [m].");
	m.def("overlap_floor", overlapFloor, "vertices"_a, "radius"_a, "pose"_a, "max_gap"_a,
	        "Manifolds of the half plane y ≤ 0 and a rounded polygon at N poses (N, 3).");
	m.def(
	        "polygon_radii",
	        [](const Array& vertices, double rounding) {
		        const PlanarShape shape = polygonShape(vertices, rounding);
		        return py::make_tuple(shape.radius(), shape.inscribedRadius());
	        },
	        "vertices"_a, "radius"_a,
	        "Circumscribed and inscribed radius [m] of a rounded polygon about the origin.");
	m.def("overlap_wall", overlapWall, "origin"_a, "normal"_a, "stadium"_a, "pose"_a, "max_gap"_a,
	        manifold);
	m.def("deposit", depositArrays, "radii"_a, "width"_a,
	        "Centres (n, 2) [m] of discs deposited one by one, each at the lowest free\n"
	        "position in the box 0 <= x <= width, y >= 0.");
}

} // namespace rcr

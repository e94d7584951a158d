#include "geometry/convex_polygon.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

namespace rcr {

template <class... Parts> static std::string text(const Parts&... parts)
{
	std::ostringstream out;
	(out << ... << parts);
	return out.str();
}

ConvexPolygon::ConvexPolygon(std::vector<Vec2> corners)
        : vertices(std::move(corners))
        , inscribed(std::numeric_limits<double>::infinity())
        , circumscribed(0)
{
	for (std::size_t k = 0; k < vertices.size(); ++k) {
		const Vec2 side = vertices[(k + 1) % vertices.size()] - vertices[k];
		length.push_back(norm(side));
		along.push_back(1 / length.back() * side);
		inscribed     = std::min(inscribed, dot(vertices[k], outward(along.back())));
		circumscribed = std::max(circumscribed, norm(vertices[k]));
	}
}

bool ConvexPolygon::operator==(const ConvexPolygon& other) const
{
	return std::equal(vertices.begin(), vertices.end(), other.vertices.begin(),
	        other.vertices.end(), [](Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; });
}

std::string polygonError(const std::vector<Vec2>& v, double rounding)
{
	const int  count = int(v.size());
	const auto point = [&](int k) { return text("(", v[k].x, ", ", v[k].y, ")"); };
	if (count < 1 || count > mostVertices)
		return text(count, " vertices; expected 1 to ", mostVertices);
	if (!(rounding >= 0 && std::isfinite(rounding)))
		return text("radius = ", rounding, "; expected a finite length ≥ 0");
	for (int k = 0; k < count; ++k)
		if (!(std::isfinite(v[k].x) && std::isfinite(v[k].y)))
			return text("vertex ", k, " = ", point(k), "; expected finite coordinates");
	if (count < 3) {
		if (!(rounding > 0))
			return text("radius = ", rounding, " with ", count,
			        " vertices; expected a radius > 0 or three vertices");
		if (count == 2 && !(norm(v[1] - v[0]) > 0))
			return "two equal vertices; expected one vertex for a disc";
		return {};
	}
	double turned = 0; // sum of the exterior angles
	for (int k = 0; k < count; ++k) {
		const Vec2   before = v[k] - v[(k + count - 1) % count], after = v[(k + 1) % count] - v[k];
		const double sine = cross(before, after), size = norm(before) * norm(after);
		if (!(sine > 1e-9 * size))
			return text("vertex ", k, " = ", point(k), " is not a convex corner; expected the "
			        "corners of a convex polygon, counter-clockwise, none on a side");
		turned += std::atan2(sine, dot(before, after));
	}
	return turned < 3 * M_PI ? std::string() : "sides cross each other; expected a convex polygon";
}

PlanarMoments momentsOf(const std::vector<Vec2>& vertices, double r)
{
	const std::size_t count = vertices.size();
	Vec2              mean; // integrals about it: the digits of distant coordinates would cancel
	for (const Vec2 vertex : vertices)
		mean = mean + 1 / double(count) * vertex;
	std::vector<Vec2> v;
	for (const Vec2 vertex : vertices)
		v.push_back(vertex - mean);
	double            area = 0, second = 0; // ∫ dA, ∫ |x|² dA
	Vec2              first;                // ∫ x dA
	// core, and rectangles on its sides
	std::vector<Vec2> normals;
	for (std::size_t k = 0; count > 1 && k < count; ++k) {
		const Vec2   a = v[k], b = v[(k + 1) % count];
		const double twice = cross(a, b), length = norm(b - a);
		area += 0.5 * twice;
		first = first + twice / 6 * (a + b);
		second += twice / 12 * (dot(a, a) + dot(a, b) + dot(b, b));
		const Vec2   along = 1 / length * (b - a), n = outward(along);
		const double from = dot(a, along), to = from + length, low = dot(a, n), high = low + r;
		area += length * r;
		first = first + length * r * (0.5 * (a + b) + 0.5 * r * n);
		second += (r * (to * to * to - from * from * from)
		                  + length * (high * high * high - low * low * low)) / 3;
		normals.push_back(n);
	}
	// sectors at the vertices
	for (std::size_t k = 0; k < count; ++k) {
		double angle = 2 * M_PI / double(count); // exact for one and two vertices
		Vec2   mean;                             // ∫ unit vector dθ
		if (count > 1) {
			const Vec2 before = normals[(k + count - 1) % count], after = normals[k];
			if (count > 2) angle = std::atan2(cross(before, after), dot(before, after));
			mean = perp(before) - perp(after);
		}
		area += 0.5 * angle * r * r;
		first = first + 0.5 * angle * r * r * v[k] + r * r * r / 3 * mean;
		second += 0.5 * angle * r * r * dot(v[k], v[k]) + 2 * r * r * r / 3 * dot(v[k], mean)
		        + 0.25 * angle * r * r * r * r;
	}
	const Vec2 centroid = 1 / area * first;
	return { area, mean + centroid, second - area * dot(centroid, centroid) };
}

} // namespace rcr

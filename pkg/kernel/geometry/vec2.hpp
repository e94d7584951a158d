// Vectors in the plane.
#pragma once

#include <cmath>

namespace rcr {

struct Vec2 {
	double x = 0;
	double y = 0;
};

inline Vec2   operator+(Vec2 a, Vec2 b) { return { a.x + b.x, a.y + b.y }; }
inline Vec2   operator-(Vec2 a, Vec2 b) { return { a.x - b.x, a.y - b.y }; }
inline Vec2   operator-(Vec2 a) { return { -a.x, -a.y }; }
inline Vec2   operator*(double s, Vec2 a) { return { s * a.x, s * a.y }; }
inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }   // z component of a × b
inline Vec2   cross(double w, Vec2 r) { return { -w * r.y, w * r.x }; } // (0, 0, w) × r
inline Vec2   perp(Vec2 a) { return { -a.y, a.x }; } // a rotated by +90°; of a normal: the tangent
inline Vec2   componentwise(Vec2 a, Vec2 b) { return { a.x * b.x, a.y * b.y }; }
inline double norm(Vec2 a) { return std::sqrt(dot(a, a)); }

} // namespace rcr

// Texts of error messages.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/problem/refuse.hpp"

namespace yade::errors {

inline std::string text(Real value, int digits = 12)
{
	std::ostringstream out;
	out.precision(digits);
	out << value;
	return out.str();
}

/// "(x, y, z)"
inline std::string coordinates(const Vector3r& v)
{
	return '(' + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + ')';
}

/// "body #1", "bodies #1 and #2"
inline std::string bodyNames(const std::vector<Body::id_t>& ids)
{
	if (ids.empty()) return {};
	std::string list = ids.size() == 1 ? "body" : "bodies";
	for (std::size_t k = 0; k < ids.size(); ++k)
		list += (k == 0 ? " #" : k + 1 < ids.size() ? ", #" : " and #") + std::to_string(ids[k]);
	return list;
}

/// Throws std::invalid_argument with all parts as one text.
template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
{
	rcr::refuse("rcr: ", parts...);
}

} // namespace yade::errors

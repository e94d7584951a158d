// Checks of input, and exceptions with a composed message.
#pragma once

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace rcr {

/// Throws std::invalid_argument with all parts as one text.
template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
{
	std::ostringstream text;
	(text << ... << parts);
	throw std::invalid_argument(text.str());
}

/// Throws std::invalid_argument for a name that is not among `names`.
inline void requireKnown(
        const char* what, const std::string& name, const std::vector<std::string>& names)
{
	if (std::find(names.begin(), names.end(), name) != names.end()) return;
	std::string known;
	for (const std::string& one : names)
		known += (known.empty() ? "" : ", ") + one;
	refuse(what, " '", name, "' is not known; expected one of ", known);
}

/// Returns true if all values are finite, without a branch: x − x is 0, or NaN if x is not finite.
template <class... Values> bool finite(Values... values)
{
	return ((values - values) + ...) == 0;
}

} // namespace rcr

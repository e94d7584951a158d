// Checks of input, and exceptions with a composed message.
#pragma once

#include <sstream>
#include <stdexcept>

namespace rcr {

/// Throws std::invalid_argument with all parts as one text.
template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
{
	std::ostringstream text;
	(text << ... << parts);
	throw std::invalid_argument(text.str());
}

/// True if all values are finite, without a branch: x − x is 0, or NaN if x is not finite.
template <class... Values> bool finite(Values... values)
{
	return ((values - values) + ...) == 0;
}

} // namespace rcr

// Exceptions with a composed message.
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

} // namespace rcr

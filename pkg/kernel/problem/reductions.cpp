#include "problem/reductions.hpp"

#include "problem/refuse.hpp"

namespace rcr {

const std::vector<std::string>& Reductions::names()
{
	static const std::vector<std::string> names { "frictionless", "discs", "fixed", "islands",
		"layout" };
	return names;
}

Reductions Reductions::of(const std::vector<std::string>& wanted)
{
	const auto has = [&](const char* name) {
		return std::find(wanted.begin(), wanted.end(), name) != wanted.end();
	};
	for (const std::string& name : wanted)
		requireKnown("reduction", name, names());
	return { has("frictionless"), has("discs"), has("fixed"), has("islands"), has("layout") };
}

} // namespace rcr

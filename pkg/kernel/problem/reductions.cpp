#include "problem/reductions.hpp"

#include <algorithm>

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
	const auto has = [](const std::vector<std::string>& list, const std::string& name) {
		return std::find(list.begin(), list.end(), name) != list.end();
	};
	for (const std::string& name : wanted) {
		if (has(names(), name)) continue;
		std::string known;
		for (const std::string& one : names())
			known += ' ' + one;
		refuse("reduction '", name, "' is not known: give some of", known, ", or none");
	}
	return { has(wanted, "frictionless"), has(wanted, "discs"), has(wanted, "fixed"),
		has(wanted, "islands"), has(wanted, "layout") };
}

} // namespace rcr

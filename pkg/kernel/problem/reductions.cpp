#include "problem/reductions.hpp"

#include <algorithm>

#include "problem/refuse.hpp"

namespace rcr {

namespace {

	struct Named {
		const char* name;
		bool Reductions::*flag;
	};

	constexpr Named all[] = { { "frictionless", &Reductions::frictionless },
		                      { "discs", &Reductions::discs },
		                      { "fixed", &Reductions::fixed },
		                      { "islands", &Reductions::islands },
		                      { "layout", &Reductions::layout } };

} // namespace

const std::vector<std::string>& Reductions::names()
{
	static const std::vector<std::string> names = [] {
		std::vector<std::string> list;
		for (const Named& one : all)
			list.push_back(one.name);
		return list;
	}();
	return names;
}

Reductions Reductions::of(const std::vector<std::string>& wanted)
{
	Reductions result;
	for (const Named& one : all)
		result.*one.flag = std::find(wanted.begin(), wanted.end(), one.name) != wanted.end();
	for (const std::string& name : wanted) {
		if (std::find(names().begin(), names().end(), name) != names().end()) continue;
		std::string known;
		for (const std::string& one : names())
			known += ' ' + one;
		refuse("reduction '", name, "' is not known: give some of", known, ", or none");
	}
	return result;
}

} // namespace rcr

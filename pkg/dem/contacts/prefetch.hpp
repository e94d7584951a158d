// Prefetching for loops over YADE's objects, which lie scattered in memory.
#pragma once

#include <cstddef>

#include "dem/contacts/CdPhys.hpp"
#include "dem/contacts/RcrGeom.hpp"

namespace yade {

constexpr std::size_t prefetchAhead = 8; // iterations of a loop that cover the latency of memory

/// Index that a loop over `count` objects prefetches at index k.
inline std::size_t indexAhead(std::size_t k, std::size_t count)
{
	return std::min(k + prefetchAhead, count - 1);
}

/// Prefetches the memory of an object of type T; null is allowed.
template <class T> inline void prefetch(const void* object)
{
	for (std::size_t line = 0; line < sizeof(T); line += 64)
		__builtin_prefetch(static_cast<const char*>(object) + line);
}

inline void prefetchBody(const Body* later)
{
	if (!later) return;
	prefetch<State>(later->state.get());
	prefetch<Rcr>(later->shape.get());
}

/// Prefetches later interactions and their contacts in a loop over interactions at index k. No
/// other thread may create contacts in the meantime.
inline void prefetchContact(InteractionContainer& interactions, std::size_t k)
{
	if (k + 2 * prefetchAhead >= interactions.size()) return;
	prefetch<Interaction>(interactions[k + 2 * prefetchAhead].get());
	const Interaction& later = *interactions[k + prefetchAhead];
	if (later.isReal()) {
		prefetch<RcrGeom>(later.geom.get());
		prefetch<CdPhys>(later.phys.get());
	}
}

} // namespace yade

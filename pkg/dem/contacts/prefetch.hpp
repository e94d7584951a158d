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

/// Prefetches later interactions and their bodies in YADE's parallel loop at index k. Other threads
/// create contacts in this loop, so it reads neither geom nor phys of later interactions.
inline void prefetchPair(const Scene& scene, std::size_t k)
{
	InteractionContainer& interactions = *scene.interactions;
	if (k + 2 * prefetchAhead >= interactions.size()) return;
	prefetch<Interaction>(interactions[k + 2 * prefetchAhead].get());
	const BodyContainer& bodies = *scene.bodies;
	const auto           both   = [&](std::size_t ahead, auto fetch) {
                const Interaction& later = *interactions[k + ahead];
                fetch(bodies[later.getId1()].get());
                fetch(bodies[later.getId2()].get());
	};
	both(prefetchAhead, prefetch<Body>);
	both(prefetchAhead / 2, prefetchBody);
}

} // namespace yade

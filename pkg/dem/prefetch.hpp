// YADE's objects lie scattered in memory, each a few cache lines long. A loop over thousands of them waits for memory at each,
// unless it asks early for those of later turns.
#pragma once

#include <cstddef>

#include <core/Interaction.hpp>
#include <core/InteractionContainer.hpp>
#include <core/Scene.hpp>

#include "CdPhys.hpp"
#include "RcrGeom.hpp"

namespace yade {

constexpr std::size_t prefetchAhead = 8; // turns of a loop: at some 100 ns each more than memory takes

/// Asks for the memory of an object of the size of a T, of which nothing is read; null does no harm.
template <class T> inline void prefetch(const void* object)
{
#if defined(__GNUC__)
	for (std::size_t line = 0; line < sizeof(T); line += 64)
		__builtin_prefetch(static_cast<const char*>(object) + line);
#else
	(void)object;
#endif
}

/// In a loop over bodies, at number `id`: asks for what the later ones point to.
inline void prefetchBody(const Body* later)
{
	if (!later) return;
	prefetch<State>(later->state.get());
	prefetch<Rcr>(later->shape.get());
}

/// In a loop over interactions, at number k: asks for a later interaction, and for the contact of a less late one.
inline void prefetchContact(const InteractionContainer& interactions, std::size_t count, std::size_t k)
{
	if (k + 2 * prefetchAhead >= count) return;
	prefetch<Interaction>(interactions[k + 2 * prefetchAhead].get());
	const Interaction& later = *interactions[k + prefetchAhead];
	if (!later.isReal()) return;
	prefetch<RcrGeom>(later.geom.get());
	prefetch<CdPhys>(later.phys.get());
}

/// The same, and for the bodies that meet there.
inline void prefetchPair(const Scene& scene, std::size_t k)
{
	const InteractionContainer& interactions = *scene.interactions;
	const std::size_t           count        = scene.interactions->size();
	if (k + 2 * prefetchAhead >= count) return;
	prefetchContact(interactions, count, k);
	const BodyContainer& bodies = *scene.bodies;
	const auto           both   = [&](std::size_t turns, auto ask) {
                const Interaction& later = *interactions[k + turns];
                ask(bodies[later.getId1()].get());
                ask(bodies[later.getId2()].get());
	};
	both(prefetchAhead, prefetch<Body>);
	both(prefetchAhead / 2, prefetchBody);
}

} // namespace yade

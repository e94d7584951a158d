// The contact problem of a step in the form that sweeps run on: coloured and packed.
//
// The order of work, and with it every bit of the result, depends on the present problem alone: neither on problems seen
// before, nor on the width of the lanes, nor on the number of threads. Points outside the colours (layout.hpp) are solved
// one by one after them.
#pragma once

#include <vector>

#include "contact_problem.hpp"
#include "coulomb.hpp"
#include "layout.hpp"
#include "packed_blocks.hpp"
#include "team.hpp"

namespace rcr {

class PackedProblem {
public:
	Team team; // shares out what follows

	/// Takes the problem over, v = v_free + M⁻¹Jᵀp for its impulses; on as many lanes as packedKernels says.
	void load(const ContactProblem&, int lanes);
	/// Writes impulses, and velocities computed anew from them; `measure` then measures what was written.
	void store(ContactProblem&);

	/// Solves every point once.
	void sweep();
	/// The same, each impulse changed by `relaxation` times as much.
	void sweepRelaxed(double relaxation);
	/// The same from y = p + β (p − p_old); the velocities must be extrapolated by the same β. Returns ‖p − y‖².
	double sweepMomentum(double momentum);
	/// v ← v + β (v − v_old), v_old ← v.
	void extrapolate(double momentum);

	/// Sums for the stop criteria at the present impulses and velocities.
	Measures measure();
	/// Σ |u|² over the points for the free velocities.
	double freeVelocity2() const { return freeVelocity2_; }
	/// How often a problem had to be laid out: other pairs or kinds of bodies than the one before.
	int layouts() const { return layouts_; }
	/// Time spent on layouts so far, to find that one still stands too.
	double layoutSeconds() const { return layoutSeconds_; }

private:
	/// A point outside the colours, in the scaled velocities of packed_blocks.hpp.
	struct TailPoint {
		std::int32_t body1, body2, point;
		Vec2         normal;
		double       turn1n, turn1t, turn2n, turn2t;
		InverseMass  mass1, mass2;
		double       bias, friction;
		Delassus     w;
		Impulse      p, old;
	};

	BodyRecord freeRecord(const ContactProblem&, int body) const;
	void       fill(const ContactProblem&, const Pair&);
	void       addToTail(const ContactProblem&, const Pair&);
	Impulse    relativeVelocity(const TailPoint&) const;
	void       applyImpulse(const TailPoint&, const Impulse&);
	Impulse    solve(const TailPoint&, const Impulse& from) const;
	void       applyImpulses();

	PackedView view() { return { body_.data(), oldBody_.data(), layout_.pairBlocks().data(), point_.data() }; }
	/// kernel(chunk number) for all chunks, colour after colour.
	template <class Kernel> void byColor(Kernel kernel)
	{
		for (int color = 0; color < Coloring::colors; ++color)
			team.share(layout_.chunkBegin(color), layout_.chunkBegin(color + 1), kernel);
	}

	const PackedKernels*    kernels_ = nullptr;
	Layout                  layout_;
	std::vector<double>     inverseGyration_; // a body: 1/k
	std::vector<BodyRecord> body_, oldBody_;  // the records of the layout, and one sweep before
	std::vector<PointBlock> point_;
	std::vector<TailPoint>  tail_;
	std::vector<Measures>   partial_; // a chunk
	std::vector<double>     sum_;     // a chunk
	double                  freeVelocity2_ = 0, layoutSeconds_ = 0;
	int                     layouts_       = 0;
};

} // namespace rcr

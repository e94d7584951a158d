// The inner loops of the solvers of W and q. Compiled once for every lane width, as packed_kernels.cpp.
//
// With g = q + Σ W_kj p_j over the neighbours of row k and the symbols of packed_rows.hpp, the solution of coulomb.hpp becomes
//   n₀ = max(−g_n / w_nn, 0)                normal impulse without friction; 0 where the point opens
//   t₀ = −(g_t − w_tn g_n / w_nn) / s       tangential impulse that stops sliding
//   p_t = t₀ clamped to n₀ [−d₋, d₊],  p_n = n₀ − r p_t
#include "delassus/packed_rows.hpp"
#include "sweep/lane_records.hpp"
#include "sweep/lane_vector.hpp"

#define INLINE __attribute__((always_inline))

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	namespace {

		constexpr int lanes = RCR_LANES < sliceWidth ? RCR_LANES : sliceWidth;

		using Sum = SlotSum<sliceWidth>;

		/// N rows of a slice, from a lane on.
		template <int N> struct Rows {
			const RowView&  view;
			const RowSlice& slice;
			RowBlock&       block;
			HalfRecord*     record;
			int             lane;

			using L = Lane<N>;

			L    operator()(const double (&field)[sliceWidth]) const { return L::load(field + lane); }
			void set(double (&field)[sliceWidth], L value) const { value.store(field + lane); }

			Components<N> impulse() const
			{
				const Centres<N> p = loadCentres<N>({ record, own });
				return { p.x, p.y };
			}
			void setImpulse(const Components<N>& p) const { storeCentres<N>({ p.n, p.t }, { record, own }); }

			/// The velocities that the rows would have without their own impulses.
			INLINE Components<N> velocityWithoutOwn() const
			{
				const int            width     = N == 1 ? slice.width() : sliceWidth;
				const std::uint32_t* neighbour = view.neighbours + slice.firstNeighbour + lane;
				const double*        w         = view.numbers + slice.firstNumber + lane;
				L nn = (*this)(block.qn), nt = 0.0, tn = 0.0, tt = (*this)(block.qt); // four sums: none waits for another
				for (int i = 0; i < slice.length; ++i, neighbour += width, w += 4 * width) {
					const Centres<N> p = loadCentres<N>({ view.impulse, neighbour });

					nn = addProduct(nn, L::load(w), p.x);
					nt = addProduct(nt, L::load(w + width), p.y);
					tn = addProduct(tn, L::load(w + 2 * width), p.x);
					tt = addProduct(tt, L::load(w + 3 * width), p.y);
				}
				return { nn + nt, tn + tt };
			}

			/// The impulses that solve the rows.
			INLINE Components<N> solve() const
			{
				const Components<N> g    = velocityWithoutOwn();
				const L             stop = g.n * (*this)(block.inverseNn), n0 = max(L(0.0) - stop, L(0.0));
				const L             slip = subtractProduct(g.t, (*this)(block.tn), stop);
				const L             t0   = subtractProduct(L(0.0), slip, (*this)(block.inverseSchur));
				const L             t    = max(min(t0, n0 * (*this)(block.slidePlus)), subtractProduct(L(0.0), n0, (*this)(block.slideMinus)));
				return { subtractProduct(n0, (*this)(block.ratio), t), t };
			}

			static constexpr std::uint32_t own[sliceWidth] = { 0, 2, 4, 6, 8, 10, 12, 14 };
		};

		/// Calls visit(rows) for all rows in order, as many at once as there are lanes.
		template <class Visit> INLINE inline void forEachRow(const RowView& view, Visit visit)
		{
			for (int k = 0; k < view.count; ++k) {
				const RowSlice& slice  = view.slices[k];
				HalfRecord*     record = view.impulse + sliceWidth * k;
				if (slice.rows == 1) visit(Rows<1> { view, slice, view.blocks[k], record, 0 });
				else
					for (int lane = 0; lane < sliceWidth; lane += lanes)
						visit(Rows<lanes> { view, slice, view.blocks[k], record + lane, lane });
			}
		}

		void prepare(const RowView& view)
		{
			for (int k = 0; k < view.count; ++k)
				for (int lane = 0; lane < sliceWidth; lane += lanes) {
					using L = Lane<lanes>;
					const Rows<lanes> rows { view, view.slices[k], view.blocks[k], nullptr, lane };
					RowBlock&         b  = rows.block;
					const L           nn = rows(b.nn), friction = rows(b.friction), none = 0.0, all = 1.0;
					const L           inverseNn = zeroWhere(nn <= none, all / nn), ratio = rows(b.nt) * inverseNn;
					const L           schur = rows(b.tt) - rows(b.tn) * ratio;
					const L           limit = zeroWhere(schur <= none, L(unlimited<Real>)), slope = friction * ratio;
					const auto        slide = [&](L with) { return select(with <= none, limit, friction / with); };
					rows.set(b.inverseNn, inverseNn);
					rows.set(b.ratio, ratio);
					rows.set(b.inverseSchur, select(schur <= none, L(unlimited<Real>), all / schur));
					rows.set(b.slidePlus, slide(all + slope));
					rows.set(b.slideMinus, slide(all - slope));
				}
		}

		/// next(rows) gives the new impulses.
		template <class Next> INLINE inline RowChange sweepBy(const RowView& view, Next next)
		{
			Sum change2, impulse2;
			forEachRow(view, [&](const auto& rows) INLINE {
				const auto p = next(rows);
				change2.add(rows.lane, square(p - rows.impulse()));
				impulse2.add(rows.lane, square(p));
				rows.setImpulse(p);
			});
			return { change2.total(), impulse2.total() };
		}

		RowChange sweep(const RowView& view)
		{
			return sweepBy(view, [](const auto& rows) INLINE { return rows.solve(); });
		}

		RowChange sweepRelaxed(const RowView& view, double relaxation)
		{
			return sweepBy(view, [=](const auto& rows) INLINE {
				const auto p = rows.impulse();
				return projectCone(p + decltype(p.n)(relaxation) * (rows.solve() - p), rows(rows.block.friction));
			});
		}

		void extrapolate(const RowView& view, double momentum)
		{
			using Few       = Lane<lanes>;
			const Few beta  = momentum;
			double*   value = &view.impulse->x;
			double*   old   = &view.old->x;
			for (long i = 0; i < 2L * sliceWidth * view.count; i += lanes) {
				const Few p = Few::load(value + i);
				addProduct(p, beta, p - Few::load(old + i)).store(old + i);
			}
		}

		RowSums measure(const RowView& view)
		{
			Sum error2, impulse2, stopping2;
			forEachRow(view, [&](const auto& rows) INLINE {
				RowBlock&  b = rows.block;
				const auto p = rows.impulse();
				auto       u = rows.velocityWithoutOwn();
				u.n          = addProduct(addProduct(u.n, rows(b.nn), p.n), rows(b.nt), p.t);
				u.t          = addProduct(addProduct(u.t, rows(b.tn), p.n), rows(b.tt), p.t);
				rows.set(b.un, u.n);
				rows.set(b.ut, u.t);
				const auto friction = rows(b.friction), scale = rows(b.inverseNn), stopping = u.n * scale;
				auto       shifted  = u;
				shifted.n           = addProduct(u.n, friction, abs(u.t));
				error2.add(rows.lane, square(p - projectCone(p - scale * shifted, friction)));
				impulse2.add(rows.lane, square(p));
				stopping2.add(rows.lane, stopping * stopping);
			});
			return { error2.total(), impulse2.total(), stopping2.total() };
		}

	} // namespace

	extern const RowKernels rowKernels;
	const RowKernels        rowKernels { prepare, sweep, sweepRelaxed, extrapolate, measure };

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr

// N doubles side by side: one kernel source for scalars, AVX2 and AVX-512. All intrinsics of the project live here.
//
// Lane<1> is a double, Lane<4> an AVX2 and Lane<8> an AVX-512 register where the compiler may use them; any other width
// is made of two halves. Every operation is one IEEE operation a lane, a product with its sum (FMA) too, so the bits do not
// depend on the width (given -ffp-contract=off); without FMA in hardware the library computes the same bits, slowly.
//
// The same source is compiled once a width with other flags. RCR_LANE_NAMESPACE keeps those copies apart, or the linker
// would keep one of them for all machines. For the same reason this file includes no library code that is inlined.
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <type_traits>

#include "sweep/packed_blocks.hpp"

#ifndef RCR_LANE_NAMESPACE
#define RCR_LANE_NAMESPACE lanes
#endif

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	/// True or false in every lane.
	template <int N> struct Mask {
		Mask<N / 2> low, high;
	};

	/// N doubles, as two halves unless specialised below.
	template <int N> struct Lane {
		using Half = Lane<N / 2>;
		Half low, high;

		Lane() = default;
		Lane(double all) : low(all), high(all) { }
		Lane(Half l, Half h) : low(l), high(h) { }
		static Lane load(const double* from) { return { Half::load(from), Half::load(from + N / 2) }; }
		void        store(double* to) const
		{
			low.store(to);
			high.store(to + N / 2);
		}
		friend Half    lowHalf(Lane a) { return a.low; }
		friend Half    highHalf(Lane a) { return a.high; }
		friend Lane    operator+(Lane a, Lane b) { return { a.low + b.low, a.high + b.high }; }
		friend Lane    operator-(Lane a, Lane b) { return { a.low - b.low, a.high - b.high }; }
		friend Lane    operator*(Lane a, Lane b) { return { a.low * b.low, a.high * b.high }; }
		friend Lane    operator/(Lane a, Lane b) { return { a.low / b.low, a.high / b.high }; }
		/// c + a b and c − a b, rounded once.
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return { addProduct(c.low, a.low, b.low), addProduct(c.high, a.high, b.high) }; }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b)
		{
			return { subtractProduct(c.low, a.low, b.low), subtractProduct(c.high, a.high, b.high) };
		}
		friend Mask<N> operator<=(Lane a, Lane b) { return { a.low <= b.low, a.high <= b.high }; }
		/// a < b ? a : b and a > b ? a : b, also for zeros of either sign.
		friend Lane    min(Lane a, Lane b) { return { min(a.low, b.low), min(a.high, b.high) }; }
		friend Lane    max(Lane a, Lane b) { return { max(a.low, b.low), max(a.high, b.high) }; }
		friend Lane    abs(Lane a) { return { abs(a.low), abs(a.high) }; }
		/// The size of a with the sign of b.
		friend Lane copySign(Lane a, Lane b) { return { copySign(a.low, b.low), copySign(a.high, b.high) }; }
		friend Lane select(Mask<N> m, Lane yes, Lane no) { return { select(m.low, yes.low, no.low), select(m.high, yes.high, no.high) }; }
		/// 0 where m holds, else a.
		friend Lane zeroWhere(Mask<N> m, Lane a) { return { zeroWhere(m.low, a.low), zeroWhere(m.high, a.high) }; }
	};

	template <> struct Mask<1> {
		std::uint64_t value; // all bits
	};

	inline std::uint64_t bitsOf(double a)
	{
		std::uint64_t bits;
		__builtin_memcpy(&bits, &a, sizeof bits);
		return bits;
	}

	inline double fromBits(std::uint64_t bits)
	{
		double a;
		__builtin_memcpy(&a, &bits, sizeof a);
		return a;
	}

	/// Choices are made on bits: whether a contact sticks or slides cannot be foreseen, and a branch would cost more.
	template <> struct Lane<1> {
		double value;

		Lane() = default;
		Lane(double v) : value(v) { }
		static Lane    load(const double* from) { return *from; }
		void           store(double* to) const { *to = value; }
		friend Lane    operator+(Lane a, Lane b) { return a.value + b.value; }
		friend Lane    operator-(Lane a, Lane b) { return a.value - b.value; }
		friend Lane    operator*(Lane a, Lane b) { return a.value * b.value; }
		friend Lane    operator/(Lane a, Lane b) { return a.value / b.value; }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return __builtin_fma(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return __builtin_fma(-a.value, b.value, c.value); }
		friend Mask<1> operator<=(Lane a, Lane b) { return { a.value <= b.value ? ~std::uint64_t(0) : 0 }; }
		friend Lane    min(Lane a, Lane b) { return a.value < b.value ? a.value : b.value; }
		friend Lane    max(Lane a, Lane b) { return a.value > b.value ? a.value : b.value; }
		friend Lane    abs(Lane a) { return __builtin_fabs(a.value); }
		friend Lane    copySign(Lane a, Lane b) { return __builtin_copysign(a.value, b.value); }
		friend Lane    select(Mask<1> m, Lane yes, Lane no) { return fromBits((bitsOf(yes.value) & m.value) | (bitsOf(no.value) & ~m.value)); }
		friend Lane    zeroWhere(Mask<1> m, Lane a) { return fromBits(bitsOf(a.value) & ~m.value); }
	};

#if defined(__AVX2__)
	template <> struct Mask<4> {
		__m256d value;
	};

	template <> struct Lane<4> {
		__m256d value;

		Lane() = default;
		Lane(double all) : value(_mm256_set1_pd(all)) { }
		Lane(__m256d v) : value(v) { }
		static Lane    load(const double* from) { return _mm256_load_pd(from); }
		void           store(double* to) const { _mm256_store_pd(to, value); }
		friend Lane    operator+(Lane a, Lane b) { return _mm256_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm256_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm256_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm256_div_pd(a.value, b.value); }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return _mm256_fmadd_pd(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return _mm256_fnmadd_pd(a.value, b.value, c.value); }
		friend Mask<4> operator<=(Lane a, Lane b) { return { _mm256_cmp_pd(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    min(Lane a, Lane b) { return _mm256_min_pd(a.value, b.value); }
		friend Lane    max(Lane a, Lane b) { return _mm256_max_pd(a.value, b.value); }
		friend Lane    abs(Lane a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			const __m256d sign = _mm256_set1_pd(-0.0);
			return _mm256_or_pd(_mm256_andnot_pd(sign, a.value), _mm256_and_pd(sign, b.value));
		}
		friend Lane select(Mask<4> m, Lane yes, Lane no) { return _mm256_blendv_pd(no.value, yes.value, m.value); }
		friend Lane zeroWhere(Mask<4> m, Lane a) { return _mm256_andnot_pd(m.value, a.value); }
	};
#endif

#if defined(__AVX512F__)
	template <> struct Mask<8> {
		__mmask8 value;
	};

	template <> struct Lane<8> {
		__m512d value;

		Lane() = default;
		Lane(double all) : value(_mm512_set1_pd(all)) { }
		Lane(__m512d v) : value(v) { }
		Lane(Lane<4> low, Lane<4> high) : value(_mm512_insertf64x4(_mm512_castpd256_pd512(low.value), high.value, 1)) { }
		friend Lane<4> lowHalf(Lane a) { return _mm512_castpd512_pd256(a.value); }
		friend Lane<4> highHalf(Lane a) { return _mm512_extractf64x4_pd(a.value, 1); }
		static Lane    load(const double* from) { return _mm512_load_pd(from); }
		void           store(double* to) const { _mm512_store_pd(to, value); }
		friend Lane    operator+(Lane a, Lane b) { return _mm512_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm512_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm512_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm512_div_pd(a.value, b.value); }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return _mm512_fmadd_pd(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return _mm512_fnmadd_pd(a.value, b.value, c.value); }
		friend Mask<8> operator<=(Lane a, Lane b) { return { _mm512_cmp_pd_mask(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    min(Lane a, Lane b) { return _mm512_min_pd(a.value, b.value); }
		friend Lane    max(Lane a, Lane b) { return _mm512_max_pd(a.value, b.value); }
		friend Lane    abs(Lane a) { return _mm512_abs_pd(a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			// bitwise choice: sign bit from b, the rest from a
			const __m512i sign = _mm512_set1_epi64((long long)0x8000000000000000ull);
			return _mm512_castsi512_pd(_mm512_ternarylogic_epi64(sign, _mm512_castpd_si512(b.value), _mm512_castpd_si512(a.value), 0xca));
		}
		friend Lane select(Mask<8> m, Lane yes, Lane no) { return _mm512_mask_blend_pd(m.value, no.value, yes.value); }
		friend Lane zeroWhere(Mask<8> m, Lane a) { return _mm512_mask_blend_pd(m.value, a.value, _mm512_setzero_pd()); }
	};
#endif

	/// Parts a calculation in two for the compiler, which would mix them and run out of registers.
	inline void keepOrder() { __atomic_signal_fence(__ATOMIC_SEQ_CST); }

	// ---- body records: N records of four doubles to and from four lanes. Plain loads and a transpose in registers are
	// more than twice as fast as hardware gathers and scatters.

	template <int N> struct Bodies {
		Lane<N> x, y, spin, inverseMass;
	};

	/// Without what turns.
	template <int N> struct Centres {
		Lane<N> x, y;
	};

	/// Where the records of N bodies are.
	template <int N> struct Places {
		HalfRecord*          body;
		const std::uint32_t* offset;

		BodyRecord&   operator[](int i) const { return recordAt<BodyRecord>(body, offset[i]); }
		HalfRecord&   half(int i) const { return recordAt<HalfRecord>(body, offset[i]); }
		Places<N / 2> low() const { return { body, offset }; }
		Places<N / 2> high() const { return { body, offset + N / 2 }; }
	};

	template <int N> inline Bodies<N> loadBodies(const Places<N>& at)
	{
		if constexpr (N == 1) return { at[0].x, at[0].y, at[0].spin, at[0].inverseMass };
		else {
			const Bodies<N / 2> low = loadBodies<N / 2>(at.low()), high = loadBodies<N / 2>(at.high());
			return { { low.x, high.x }, { low.y, high.y }, { low.spin, high.spin }, { low.inverseMass, high.inverseMass } };
		}
	}

	template <int N> inline Centres<N> loadCentres(const Places<N>& at)
	{
		if constexpr (N == 1) return { at.half(0).x, at.half(0).y };
		else {
			const Centres<N / 2> low = loadCentres<N / 2>(at.low()), high = loadCentres<N / 2>(at.high());
			return { { low.x, high.x }, { low.y, high.y } };
		}
	}

	/// Back to where they were; the bodies must be distinct.
	template <int N> inline void storeBodies(const Bodies<N>& v, const Places<N>& at)
	{
		if constexpr (N == 1) at[0] = { v.x.value, v.y.value, v.spin.value, v.inverseMass.value };
		else {
			storeBodies<N / 2>({ lowHalf(v.x), lowHalf(v.y), lowHalf(v.spin), lowHalf(v.inverseMass) }, at.low());
			storeBodies<N / 2>({ highHalf(v.x), highHalf(v.y), highHalf(v.spin), highHalf(v.inverseMass) }, at.high());
		}
	}

	template <int N> inline void storeCentres(const Centres<N>& v, const Places<N>& at)
	{
		if constexpr (N == 1) at.half(0).x = v.x.value, at.half(0).y = v.y.value;
		else {
			storeCentres<N / 2>({ lowHalf(v.x), lowHalf(v.y) }, at.low());
			storeCentres<N / 2>({ highHalf(v.x), highHalf(v.y) }, at.high());
		}
	}

#if defined(__AVX2__)
	template <> inline Bodies<4> loadBodies<4>(const Places<4>& at)
	{
		// (x, y) of records 0 | 2 and 1 | 3, then unpack; the same for (spin, 1/m)
		const auto halves = [&](int i, int part) __attribute__((always_inline)) {
			return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(&at[i].x + part)), _mm_load_pd(&at[i + 2].x + part), 1);
		};
		const __m256d v02 = halves(0, 0), v13 = halves(1, 0), w02 = halves(0, 2), w13 = halves(1, 2);
		return { _mm256_unpacklo_pd(v02, v13), _mm256_unpackhi_pd(v02, v13), _mm256_unpacklo_pd(w02, w13), _mm256_unpackhi_pd(w02, w13) };
	}

	template <> inline void storeBodies<4>(const Bodies<4>& v, const Places<4>& at)
	{
		const auto put = [&](__m256d pair, int i, int part) __attribute__((always_inline)) {
			_mm_store_pd(&at[i].x + part, _mm256_castpd256_pd128(pair));
			_mm_store_pd(&at[i + 2].x + part, _mm256_extractf128_pd(pair, 1));
		};
		put(_mm256_unpacklo_pd(v.x.value, v.y.value), 0, 0);
		put(_mm256_unpackhi_pd(v.x.value, v.y.value), 1, 0);
		put(_mm256_unpacklo_pd(v.spin.value, v.inverseMass.value), 0, 2);
		put(_mm256_unpackhi_pd(v.spin.value, v.inverseMass.value), 1, 2);
	}

	template <> inline Centres<4> loadCentres<4>(const Places<4>& at)
	{
		const auto halves = [&](int i) __attribute__((always_inline)) {
			return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(&at.half(i).x)), _mm_load_pd(&at.half(i + 2).x), 1);
		};
		const __m256d v02 = halves(0), v13 = halves(1);
		return { _mm256_unpacklo_pd(v02, v13), _mm256_unpackhi_pd(v02, v13) };
	}

	template <> inline void storeCentres<4>(const Centres<4>& v, const Places<4>& at)
	{
		const auto put = [&](__m256d pair, int i) __attribute__((always_inline)) {
			_mm_store_pd(&at.half(i).x, _mm256_castpd256_pd128(pair));
			_mm_store_pd(&at.half(i + 2).x, _mm256_extractf128_pd(pair, 1));
		};
		put(_mm256_unpacklo_pd(v.x.value, v.y.value), 0);
		put(_mm256_unpackhi_pd(v.x.value, v.y.value), 1);
	}
#endif

#if defined(__AVX512F__)
	// Four 4×4 transposes at a time. The low half of a register takes one record, the high half another, so that every
	// record is one load and one store.
	template <> inline Bodies<8> loadBodies<8>(const Places<8>& at)
	{
		const auto two = [&](int low, int high) __attribute__((always_inline)) {
			return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(&at[low].x)), _mm256_load_pd(&at[high].x), 1);
		};
		// (x₀ x₁ s₀ s₁ x₂ x₃ s₂ s₃), likewise with y and 1/m, and the same of the upper four
		const __m512d v02 = two(0, 2), v13 = two(1, 3), v46 = two(4, 6), v57 = two(5, 7);
		const __m512d xs0 = _mm512_unpacklo_pd(v02, v13), ym0 = _mm512_unpackhi_pd(v02, v13);
		const __m512d xs4 = _mm512_unpacklo_pd(v46, v57), ym4 = _mm512_unpackhi_pd(v46, v57);
		constexpr int even = 0x88, odd = 0xdd; // 128-bit parts 0, 2 or 1, 3 of both
		return { _mm512_shuffle_f64x2(xs0, xs4, even), _mm512_shuffle_f64x2(ym0, ym4, even),
			 _mm512_shuffle_f64x2(xs0, xs4, odd), _mm512_shuffle_f64x2(ym0, ym4, odd) };
	}

	template <> inline void storeBodies<8>(const Bodies<8>& v, const Places<8>& at)
	{
		const auto put = [&](__m512d pair, int low, int high) __attribute__((always_inline)) {
			_mm256_store_pd(&at[low].x, _mm512_castpd512_pd256(pair));
			_mm256_store_pd(&at[high].x, _mm512_extractf64x4_pd(pair, 1));
		};
		// (x₀ y₀ x₂ y₂ x₄ y₄ x₆ y₆) and so on; then a record is part i of both
		const __m512d xy0 = _mm512_unpacklo_pd(v.x.value, v.y.value), xy1 = _mm512_unpackhi_pd(v.x.value, v.y.value);
		const __m512d sm0 = _mm512_unpacklo_pd(v.spin.value, v.inverseMass.value), sm1 = _mm512_unpackhi_pd(v.spin.value, v.inverseMass.value);
		const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
		put(_mm512_permutex2var_pd(xy0, low, sm0), 0, 2);
		put(_mm512_permutex2var_pd(xy1, low, sm1), 1, 3);
		put(_mm512_permutex2var_pd(xy0, high, sm0), 4, 6);
		put(_mm512_permutex2var_pd(xy1, high, sm1), 5, 7);
	}

	// A register takes four records, so that (x, y) pairs unpack in place.
	template <> inline Centres<8> loadCentres<8>(const Places<8>& at)
	{
		const auto two = [&](int i) __attribute__((always_inline)) {
			return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(&at.half(i).x)), _mm_load_pd(&at.half(i + 2).x), 1);
		};
		const auto four = [&](int i) __attribute__((always_inline)) {
			return _mm512_insertf64x4(_mm512_castpd256_pd512(two(i)), two(i + 4), 1);
		};
		const __m512d even = four(0), odd = four(1);
		return { _mm512_unpacklo_pd(even, odd), _mm512_unpackhi_pd(even, odd) };
	}

	template <> inline void storeCentres<8>(const Centres<8>& v, const Places<8>& at)
	{
		const auto two = [&](__m256d pair, int i) __attribute__((always_inline)) {
			_mm_store_pd(&at.half(i).x, _mm256_castpd256_pd128(pair));
			_mm_store_pd(&at.half(i + 2).x, _mm256_extractf128_pd(pair, 1));
		};
		const auto four = [&](__m512d pairs, int i) __attribute__((always_inline)) {
			two(_mm512_castpd512_pd256(pairs), i);
			two(_mm512_extractf64x4_pd(pairs, 1), i + 4);
		};
		four(_mm512_unpacklo_pd(v.x.value, v.y.value), 0);
		four(_mm512_unpackhi_pd(v.x.value, v.y.value), 1);
	}
#endif

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr

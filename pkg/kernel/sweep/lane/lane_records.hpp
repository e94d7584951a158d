// Loads records of bodies (packed_blocks.hpp) into lanes, and stores them. Compiled like lane.hpp.
//
// Plain loads and a transpose in registers are more than twice as fast as gathers and scatters.
#pragma once

#include "sweep/lane/lane.hpp"
#include "sweep/lane/packed_blocks.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

/// Whole records.
template <int N> struct Bodies {
	Lane<N> x, y, spin, inverseMass;
};

/// Half records.
template <int N> struct Centers {
	Lane<N> x, y;
};

/// The places of N records.
template <int N> struct Places {
	Real*                body;
	const std::uint32_t* offset;

	Real*         operator[](int i) const { return body + offset[i]; }
	Places<N / 2> low() const { return { body, offset }; }
	Places<N / 2> high() const { return { body, offset + N / 2 }; }
};

template <int N> inline Bodies<N> loadBodies(const Places<N>& at)
{
	if constexpr (N == 1)
		return { at[0][record::x], at[0][record::y], at[0][record::spin],
			at[0][record::inverseMass] };
	else {
		const Bodies<N / 2> low = loadBodies<N / 2>(at.low()), high = loadBodies<N / 2>(at.high());
		return { { low.x, high.x }, { low.y, high.y }, { low.spin, high.spin },
			{ low.inverseMass, high.inverseMass } };
	}
}

template <int N> inline Centers<N> loadCenters(const Places<N>& at)
{
	if constexpr (N == 1) return { at[0][record::x], at[0][record::y] };
	else {
		const Centers<N / 2> low  = loadCenters<N / 2>(at.low()),
		                     high = loadCenters<N / 2>(at.high());
		return { { low.x, high.x }, { low.y, high.y } };
	}
}

/// The records must be distinct.
template <int N> inline void storeBodies(const Bodies<N>& v, const Places<N>& at)
{
	if constexpr (N == 1) {
		at[0][record::x]           = v.x.value;
		at[0][record::y]           = v.y.value;
		at[0][record::spin]        = v.spin.value;
		at[0][record::inverseMass] = v.inverseMass.value;
	} else {
		storeBodies<N / 2>({ lowHalf(v.x), lowHalf(v.y), lowHalf(v.spin), lowHalf(v.inverseMass) },
		        at.low());
		storeBodies<N / 2>(
		        { highHalf(v.x), highHalf(v.y), highHalf(v.spin), highHalf(v.inverseMass) },
		        at.high());
	}
}

template <int N> inline void storeCenters(const Centers<N>& v, const Places<N>& at)
{
	if constexpr (N == 1) at[0][record::x] = v.x.value, at[0][record::y] = v.y.value;
	else {
		storeCenters<N / 2>({ lowHalf(v.x), lowHalf(v.y) }, at.low());
		storeCenters<N / 2>({ highHalf(v.x), highHalf(v.y) }, at.high());
	}
}

#if defined(__AVX2__) && !defined(RCR_SINGLE)
/// Two numbers of record i, then of record i + 2, from number `part` of each.
inline __attribute__((always_inline)) __m256d loadTwo(const Places<4>& at, int i, int part)
{
	return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(at[i] + part)),
	        _mm_load_pd(at[i + 2] + part), 1);
}

inline __attribute__((always_inline)) void storeTwo(
        __m256d numbers, const Places<4>& at, int i, int part)
{
	_mm_store_pd(at[i] + part, _mm256_castpd256_pd128(numbers));
	_mm_store_pd(at[i + 2] + part, _mm256_extractf128_pd(numbers, 1));
}

template <> inline Centers<4> loadCenters<4>(const Places<4>& at)
{
	const __m256d v02 = loadTwo(at, 0, 0), v13 = loadTwo(at, 1, 0);
	return { _mm256_unpacklo_pd(v02, v13), _mm256_unpackhi_pd(v02, v13) };
}

template <> inline void storeCenters<4>(const Centers<4>& v, const Places<4>& at)
{
	storeTwo(_mm256_unpacklo_pd(v.x.value, v.y.value), at, 0, 0);
	storeTwo(_mm256_unpackhi_pd(v.x.value, v.y.value), at, 1, 0);
}

template <> inline Bodies<4> loadBodies<4>(const Places<4>& at)
{
	const __m256d v02 = loadTwo(at, 0, 0), v13 = loadTwo(at, 1, 0), w02 = loadTwo(at, 0, 2),
	              w13 = loadTwo(at, 1, 2);
	return { _mm256_unpacklo_pd(v02, v13), _mm256_unpackhi_pd(v02, v13),
		_mm256_unpacklo_pd(w02, w13), _mm256_unpackhi_pd(w02, w13) };
}

template <> inline void storeBodies<4>(const Bodies<4>& v, const Places<4>& at)
{
	storeTwo(_mm256_unpacklo_pd(v.x.value, v.y.value), at, 0, 0);
	storeTwo(_mm256_unpackhi_pd(v.x.value, v.y.value), at, 1, 0);
	storeTwo(_mm256_unpacklo_pd(v.spin.value, v.inverseMass.value), at, 0, 2);
	storeTwo(_mm256_unpackhi_pd(v.spin.value, v.inverseMass.value), at, 1, 2);
}
#endif

#if defined(__AVX512F__) && !defined(RCR_SINGLE)
// Four 4×4 transposes at a time. Each half of a register takes one record, so each record needs
// one load and one store.
template <> inline Bodies<8> loadBodies<8>(const Places<8>& at)
{
	const auto two = [&](int low, int high) __attribute__((always_inline))
	{
		return _mm512_insertf64x4(
		        _mm512_castpd256_pd512(_mm256_load_pd(at[low])), _mm256_load_pd(at[high]), 1);
	};
	// (x₀ x₁ s₀ s₁ x₂ x₃ s₂ s₃) and (y₀ y₁ m₀ m₁ …), then records 4 to 7
	const __m512d v02 = two(0, 2), v13 = two(1, 3), v46 = two(4, 6), v57 = two(5, 7);
	const __m512d xs0 = _mm512_unpacklo_pd(v02, v13), ym0 = _mm512_unpackhi_pd(v02, v13);
	const __m512d xs4 = _mm512_unpacklo_pd(v46, v57), ym4 = _mm512_unpackhi_pd(v46, v57);
	constexpr int even = 0x88, odd = 0xdd; // 128-bit parts 0, 2 or 1, 3 of both
	return { _mm512_shuffle_f64x2(xs0, xs4, even), _mm512_shuffle_f64x2(ym0, ym4, even),
		_mm512_shuffle_f64x2(xs0, xs4, odd), _mm512_shuffle_f64x2(ym0, ym4, odd) };
}

template <> inline void storeBodies<8>(const Bodies<8>& v, const Places<8>& at)
{
	const auto put = [&](__m512d pair, int low, int high) __attribute__((always_inline))
	{
		_mm256_store_pd(at[low], _mm512_castpd512_pd256(pair));
		_mm256_store_pd(at[high], _mm512_extractf64x4_pd(pair, 1));
	};
	// (x₀ y₀ x₂ y₂ x₄ y₄ x₆ y₆) …; record 2 i is part i of xy0 and sm0
	const __m512d xy0  = _mm512_unpacklo_pd(v.x.value, v.y.value),
	              xy1  = _mm512_unpackhi_pd(v.x.value, v.y.value);
	const __m512d sm0  = _mm512_unpacklo_pd(v.spin.value, v.inverseMass.value),
	              sm1  = _mm512_unpackhi_pd(v.spin.value, v.inverseMass.value);
	const __m512i low  = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
	              high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
	put(_mm512_permutex2var_pd(xy0, low, sm0), 0, 2);
	put(_mm512_permutex2var_pd(xy1, low, sm1), 1, 3);
	put(_mm512_permutex2var_pd(xy0, high, sm0), 4, 6);
	put(_mm512_permutex2var_pd(xy1, high, sm1), 5, 7);
}
#endif

#if defined(__AVX2__) && defined(RCR_SINGLE)
// A record is one 128-bit part of a register. Each part of four registers is transposed.
template <> inline Bodies<8> loadBodies<8>(const Places<8>& at)
{
	const auto two = [&](int i) __attribute__((always_inline))
	{
		return _mm256_insertf128_ps(
		        _mm256_castps128_ps256(_mm_load_ps(at[i])), _mm_load_ps(at[i + 4]), 1);
	};
	const __m256 r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
	const __m256 xy01 = _mm256_unpacklo_ps(r0, r1),
	             xy23 = _mm256_unpacklo_ps(r2, r3); // x₀ x₁ y₀ y₁
	const __m256 sm01 = _mm256_unpackhi_ps(r0, r1), sm23 = _mm256_unpackhi_ps(r2, r3);
	return { _mm256_shuffle_ps(xy01, xy23, 0x44), _mm256_shuffle_ps(xy01, xy23, 0xee),
		_mm256_shuffle_ps(sm01, sm23, 0x44), _mm256_shuffle_ps(sm01, sm23, 0xee) };
}

template <> inline void storeBodies<8>(const Bodies<8>& v, const Places<8>& at)
{
	const auto put = [&](__m256 two, int i) __attribute__((always_inline))
	{
		_mm_store_ps(at[i], _mm256_castps256_ps128(two));
		_mm_store_ps(at[i + 4], _mm256_extractf128_ps(two, 1));
	};
	const __m256 xy01 = _mm256_unpacklo_ps(v.x.value, v.y.value),
	             xy23 = _mm256_unpackhi_ps(v.x.value, v.y.value); // x₀ y₀ x₁ y₁
	const __m256 sm01 = _mm256_unpacklo_ps(v.spin.value, v.inverseMass.value),
	             sm23 = _mm256_unpackhi_ps(v.spin.value, v.inverseMass.value);
	put(_mm256_shuffle_ps(xy01, sm01, 0x44), 0);
	put(_mm256_shuffle_ps(xy01, sm01, 0xee), 1);
	put(_mm256_shuffle_ps(xy23, sm23, 0x44), 2);
	put(_mm256_shuffle_ps(xy23, sm23, 0xee), 3);
}

template <> inline Centers<8> loadCenters<8>(const Places<8>& at)
{
	const auto two = [&](int i) __attribute__((always_inline))
	{
		// __m64 may alias floats
		const auto* low  = reinterpret_cast<const __m64*>(at[i]);
		const auto* high = reinterpret_cast<const __m64*>(at[i + 1]);
		return _mm_loadh_pi(_mm_loadl_pi(_mm_setzero_ps(), low), high);
	};
	const __m256 xy01 = _mm256_insertf128_ps(_mm256_castps128_ps256(two(0)), two(4), 1);
	const __m256 xy23 = _mm256_insertf128_ps(_mm256_castps128_ps256(two(2)), two(6), 1);
	return { _mm256_shuffle_ps(xy01, xy23, 0x88), _mm256_shuffle_ps(xy01, xy23, 0xdd) };
}

template <> inline void storeCenters<8>(const Centers<8>& v, const Places<8>& at)
{
	const auto put = [&](__m128 two, int i) __attribute__((always_inline))
	{
		_mm_storel_pi(reinterpret_cast<__m64*>(at[i]), two);
		_mm_storeh_pi(reinterpret_cast<__m64*>(at[i + 1]), two);
	};
	const __m256 xy01 = _mm256_unpacklo_ps(v.x.value, v.y.value),
	             xy23 = _mm256_unpackhi_ps(v.x.value, v.y.value);
	put(_mm256_castps256_ps128(xy01), 0);
	put(_mm256_castps256_ps128(xy23), 2);
	put(_mm256_extractf128_ps(xy01, 1), 4);
	put(_mm256_extractf128_ps(xy23, 1), 6);
}
#endif

#if defined(__AVX512F__) && defined(RCR_SINGLE)
template <> inline Bodies<16> loadBodies<16>(const Places<16>& at)
{
	const auto four = [&](int i) __attribute__((always_inline))
	{
		const __m512 two = _mm512_insertf32x4(
		        _mm512_castps128_ps512(_mm_load_ps(at[i])), _mm_load_ps(at[i + 4]), 1);
		return _mm512_insertf32x4(
		        _mm512_insertf32x4(two, _mm_load_ps(at[i + 8]), 2), _mm_load_ps(at[i + 12]), 3);
	};
	const __m512 r0 = four(0), r1 = four(1), r2 = four(2), r3 = four(3);
	const __m512 xy01 = _mm512_unpacklo_ps(r0, r1), xy23 = _mm512_unpacklo_ps(r2, r3);
	const __m512 sm01 = _mm512_unpackhi_ps(r0, r1), sm23 = _mm512_unpackhi_ps(r2, r3);
	return { _mm512_shuffle_ps(xy01, xy23, 0x44), _mm512_shuffle_ps(xy01, xy23, 0xee),
		_mm512_shuffle_ps(sm01, sm23, 0x44), _mm512_shuffle_ps(sm01, sm23, 0xee) };
}

template <> inline void storeBodies<16>(const Bodies<16>& v, const Places<16>& at)
{
	const auto put = [&](__m512 four, int i) __attribute__((always_inline))
	{
		_mm_store_ps(at[i], _mm512_castps512_ps128(four));
		_mm_store_ps(at[i + 4], _mm512_extractf32x4_ps(four, 1));
		_mm_store_ps(at[i + 8], _mm512_extractf32x4_ps(four, 2));
		_mm_store_ps(at[i + 12], _mm512_extractf32x4_ps(four, 3));
	};
	const __m512 xy01 = _mm512_unpacklo_ps(v.x.value, v.y.value),
	             xy23 = _mm512_unpackhi_ps(v.x.value, v.y.value);
	const __m512 sm01 = _mm512_unpacklo_ps(v.spin.value, v.inverseMass.value),
	             sm23 = _mm512_unpackhi_ps(v.spin.value, v.inverseMass.value);
	put(_mm512_shuffle_ps(xy01, sm01, 0x44), 0);
	put(_mm512_shuffle_ps(xy01, sm01, 0xee), 1);
	put(_mm512_shuffle_ps(xy23, sm23, 0x44), 2);
	put(_mm512_shuffle_ps(xy23, sm23, 0xee), 3);
}
#endif

} // namespace rcr::RCR_LANE_NAMESPACE

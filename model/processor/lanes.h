// Numbers side by side in the processor's vector registers.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace tribotrack::model::internal {

/// L doubles that are added and multiplied at once; wider than the processor's registers where need be.
template <int L>
struct LanesOf {
  typedef double Type __attribute__((vector_size(8 * L)));
};
template <int L>
using Lanes = typename LanesOf<L>::Type;

/// What the compiler's vectors lack. `Set` names the instruction set that the including file is compiled for:
/// each gets functions of its own, so that the linker cannot hand one processor's code to another.
template <class Set, int L>
struct LaneMath {
  using V = Lanes<L>;

  [[gnu::always_inline]] static V load(const double* from) { return *reinterpret_cast<const V*>(from); }
  [[gnu::always_inline]] static void store(const V& v, double* to) { *reinterpret_cast<V*>(to) = v; }

  [[gnu::always_inline]] static V sqrt(const V& v) {
    V root;
    const double* from = reinterpret_cast<const double*>(&v);
    double* to = reinterpret_cast<double*>(&root);
#if defined(__AVX512F__)
    if constexpr (L % 8 == 0) {
      for (int i = 0; i < L; i += 8) _mm512_store_pd(to + i, _mm512_sqrt_pd(_mm512_load_pd(from + i)));
      return root;
    }
#endif
#if defined(__AVX__)
    for (int i = 0; i < L; i += 4) _mm256_store_pd(to + i, _mm256_sqrt_pd(_mm256_load_pd(from + i)));
#elif defined(__SSE2__)
    for (int i = 0; i < L; i += 2) _mm_store_pd(to + i, _mm_sqrt_pd(_mm_load_pd(from + i)));
#else
    for (int i = 0; i < L; ++i) to[i] = __builtin_sqrt(from[i]);
#endif
    return root;
  }

  /// Whether every lane of v is below the bound (false for NaN).
  [[gnu::always_inline]] static bool all_below(const V& v, double bound) {
    const double* from = reinterpret_cast<const double*>(&v);
#if defined(__AVX512F__)
    if constexpr (L == 8)
      return _mm512_cmp_pd_mask(_mm512_load_pd(from), _mm512_set1_pd(bound), _CMP_LT_OQ) == 0xff;
#endif
#if defined(__AVX__)
    __m256d below = _mm256_cmp_pd(_mm256_load_pd(from), _mm256_set1_pd(bound), _CMP_LT_OQ);
    for (int i = 4; i < L; i += 4)
      below =
          _mm256_and_pd(below, _mm256_cmp_pd(_mm256_load_pd(from + i), _mm256_set1_pd(bound), _CMP_LT_OQ));
    return _mm256_movemask_pd(below) == 0xf;
#elif defined(__SSE2__)
    __m128d below = _mm_cmplt_pd(_mm_load_pd(from), _mm_set1_pd(bound));
    for (int i = 2; i < L; i += 2)
      below = _mm_and_pd(below, _mm_cmplt_pd(_mm_load_pd(from + i), _mm_set1_pd(bound)));
    return _mm_movemask_pd(below) == 0x3;
#else
    for (int i = 0; i < L; ++i)
      if (!(from[i] < bound)) return false;
    return true;
#endif
  }

  [[gnu::always_inline]] static double sum(const V& v) {
    const double* from = reinterpret_cast<const double*>(&v);
    double even = from[0], odd = from[1];
    for (int i = 2; i < L; i += 2) {
      even += from[i];
      odd += from[i + 1];
    }
    return even + odd;
  }
};

}  // namespace tribotrack::model::internal

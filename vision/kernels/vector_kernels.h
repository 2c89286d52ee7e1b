// Arithmetic in the processor's vectors: the same source is compiled for several instruction sets, and which
// of them runs is chosen at run time. A plain loop that the compiler vectorises itself is marked
// TRIBOTRACK_CLONES. A file of kernels written in vectors states its functions once, in a macro
// TRIBOTRACK_VARIANT, and expands it for the baseline and for TRIBOTRACK_AVX2.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

/// What variants are made of: no function call, or its target would be the wrong one.
#define TRIBOTRACK_KERNEL [[gnu::always_inline]] static inline

#if defined(__x86_64__)
#define TRIBOTRACK_AVX2 [[gnu::target("avx2,fma")]]
#ifdef __SANITIZE_THREAD__  // clones are chosen before the thread sanitizer has started: it would crash
#define TRIBOTRACK_CLONES
#else
#define TRIBOTRACK_CLONES [[gnu::target_clones("arch=x86-64-v3", "default")]]
#endif
#else
#define TRIBOTRACK_AVX2
#define TRIBOTRACK_CLONES
#endif

namespace tribotrack::vision {

/// `count` numbers; the compiler makes as many registers of them as the function's target needs.
template <class Number, int count>
struct VectorOf {
  using type [[gnu::vector_size(sizeof(Number) * count)]] = Number;
};

// References, not values: vectors are never passed between functions of different targets.
template <class Number, class Lanes>
TRIBOTRACK_KERNEL void load(const Number* from, Lanes& to) {
  std::memcpy(&to, from, sizeof to);
}
template <class Number, class Lanes>
TRIBOTRACK_KERNEL void store(const Lanes& from, Number* to) {
  std::memcpy(to, &from, sizeof from);
}
template <class Lanes>
TRIBOTRACK_KERNEL double sum(const Lanes& v) {
  double s = 0;
  for (std::size_t i = 0; i < sizeof v / sizeof v[0]; ++i) s += static_cast<double>(v[i]);
  return s;
}

inline bool runs_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

/// The variants this processor can run, slowest first.
template <class Kernels>
std::vector<Kernels> runnable(const Kernels& baseline, const Kernels& avx2) {
  if (runs_avx2()) return {baseline, avx2};
  return {baseline};
}

}  // namespace tribotrack::vision

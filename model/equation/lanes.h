// Numbers side by side in the processor's vector registers. A function marked TRIBOTRACK_CLONES is compiled
// for several instruction sets, and which of them runs is chosen when the program is loaded; results differ
// between them by rounding only.
#pragma once

/// What clones call: inlined, or its target would be the wrong one.
#define TRIBOTRACK_KERNEL [[gnu::always_inline]] static inline

#if defined(__x86_64__) && \
    !defined(__SANITIZE_THREAD__)  // clones are chosen before that sanitizer has started
#define TRIBOTRACK_CLONES [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define TRIBOTRACK_CLONES
#endif

namespace tribotrack::model::internal {

/// L doubles that are added and multiplied at once; wider than the processor's registers where need be.
template <int L>
struct LanesOf {
  typedef double Type __attribute__((vector_size(8 * L)));
};
template <int L>
using Lanes = typename LanesOf<L>::Type;

// What the compiler's vectors lack.

template <class V>
TRIBOTRACK_KERNEL V load(const double* from) {
  return *reinterpret_cast<const V*>(from);
}
template <class V>
TRIBOTRACK_KERNEL void store(const V& v, double* to) {
  *reinterpret_cast<V*>(to) = v;
}

template <class V>
TRIBOTRACK_KERNEL V root(const V& v) {
  V of;
  for (unsigned i = 0; i < sizeof v / sizeof v[0]; ++i) of[i] = __builtin_sqrt(v[i]);
  return of;
}

/// Whether every lane of v is below the bound (false for NaN).
template <class V>
TRIBOTRACK_KERNEL bool all_below(const V& v, double bound) {
  const auto below = v < V{} + bound;
  auto all = below[0];
  for (unsigned i = 1; i < sizeof v / sizeof v[0]; ++i) all &= below[i];
  return all != 0;
}

template <class V>
TRIBOTRACK_KERNEL double sum(const V& v) {
  double even = v[0], odd = v[1];
  for (unsigned i = 2; i < sizeof v / sizeof v[0]; i += 2) {
    even += v[i];
    odd += v[i + 1];
  }
  return even + odd;
}

}  // namespace tribotrack::model::internal

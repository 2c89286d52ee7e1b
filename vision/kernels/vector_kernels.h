// Arithmetic in the processor's vectors: a function marked TRIBOTRACK_CLONES is compiled for several
// instruction sets, and which of them runs is chosen when the program is loaded.
#pragma once

#include <cstddef>
#include <cstring>

/// What clones call: inlined, or its target would be the wrong one.
#define TRIBOTRACK_KERNEL [[gnu::always_inline]] static inline

#if defined(__x86_64__)
#ifdef __SANITIZE_THREAD__  // clones are chosen before the thread sanitizer has started: it would crash
#define TRIBOTRACK_CLONES
#else
#define TRIBOTRACK_CLONES [[gnu::target_clones("arch=x86-64-v3", "default")]]
#endif
#else
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

}  // namespace tribotrack::vision

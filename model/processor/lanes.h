// Numbers side by side in the processor's vector registers.
#pragma once

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
    for (int i = 0; i < L; ++i) root[i] = __builtin_sqrt(v[i]);
    return root;
  }

  /// Whether every lane of v is below the bound (false for NaN).
  [[gnu::always_inline]] static bool all_below(const V& v, double bound) {
    const auto below = v < V{} + bound;
    auto all = below[0];
    for (int i = 1; i < L; ++i) all &= below[i];
    return all != 0;
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

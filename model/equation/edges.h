// The friction pulse's edges as phases of one cycle.
#pragma once

#include <algorithm>
#include <array>

#include "model/equation/jet.h"
#include "model/equation/phase.h"

namespace tribotrack::model::internal {

/// One switch of the friction, at local phases s + 2 pi n. Computed from its definition, never accumulated.
template <class T>
struct Edge {
  double s = 0;       ///< in [0, 2 pi)
  T change{};         ///< derivatives of s (value 0)
  bool opens = true;  ///< to mu2
};

/// The two edges in the order in which they are met in a cycle that starts at the local phase 0.
template <class T>
struct Edges {
  std::array<Edge<T>, 2> edge;
  int count = 0;
  bool open_at_start = false;  ///< whether a pulse opened before s = 0 still holds there
};

/// `opening_phase` + `opening_shift` = phi + lag, minus `start_phase`; the pulse lasts `width`.
template <class T>
Edges<T> pulse_edges(const T& phi, const T& lag, const T& width, double start_phase) {
  Edges<T> edges;
  const double w = value(width);
  if (derivative_count<T> == 0 && w == 0) return edges;
  // Each angle reduced by itself: a sum of huge ones would lose digits.
  const double sum = reduce(value(phi)).rest + reduce(value(lag)).rest - reduce(start_phase).rest;
  double opening = reduce(sum).rest;
  if (opening > kTwoPi - 8e-16 * 4) opening = 0;
  double closing = opening + w;
  edges.open_at_start = closing > kTwoPi || w == kTwoPi;
  if (closing >= kTwoPi) closing = std::max(0.0, closing - kTwoPi);
  if (w == kTwoPi) closing = opening;
  const Edge<T> open{opening, change(T(phi + lag)), true};
  const Edge<T> close{closing, change(T(phi + lag + width)), false};
  const bool open_first = opening < closing || (opening == closing && w < 1);
  edges.edge = open_first ? std::array{open, close} : std::array{close, open};
  edges.count = 2;
  return edges;
}

}  // namespace tribotrack::model::internal

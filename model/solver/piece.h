// A run as a chain of pieces, each with its polynomials.
#pragma once

#include <algorithm>
#include <vector>

#include "model/arcs/arc_stepper.h"
#include "model/series/creep.h"
#include "model/series/polar_series.h"

namespace tribotrack::model::internal {

enum class PieceKind { stick, arc, series, polar, slow };

/// One step. The coefficients lie in the chain's pool from `offset` on.
template <class T>
struct Piece {
  PieceKind kind = PieceKind::stick;
  bool reduced = false;  ///< mu2 holds
  int order = 0;
  double cycle = 0, s = 0;  ///< where it begins
  double span = 0;          ///< length in s, in sigma of a polar piece
  T shift{};                ///< the series counts from s + shift (a start from rest at an uncertain phase)
  Pair<T> position;         ///< at the begin
  Pair<T> velocity;         ///< at the begin of an arc
  size_t offset = 0;
};

template <class T>
struct Motion {
  Pair<T> velocity, position;  ///< at fixed s
};

template <class T>
class PieceChain {
 public:
  void add_stick(Piece<T> piece) { pieces_.push_back(piece); }
  void add(Piece<T> piece, const ArcStepper<T>& arcs) {
    piece.kind = PieceKind::arc;
    piece.order = 2 * arcs.table().pairs;
    piece.offset = pool_.size();
    for (int i = 0; i < piece.order; ++i) {
      const Pair<T> n = arcs.direction(i);
      pool_.push_back(n.x);
      pool_.push_back(n.y);
    }
    pieces_.push_back(piece);
  }
  void add(Piece<T> piece, const SlipSeries<T>& series) {
    piece.kind = PieceKind::series;
    store(piece, series.order, {series.x, series.y});
  }
  void add(Piece<T> piece, const PolarSeries<T>& p) {
    piece.kind = PieceKind::polar;
    store(piece, p.order, {p.log_speed, p.angle, p.s, p.x, p.y});
  }
  void add(Piece<T> piece, const SlowStep<T>& step) {
    piece.kind = PieceKind::slow;
    piece.offset = slow_.size();
    slow_.push_back(step);
    pieces_.push_back(piece);
  }
  /// The piece that holds at the local phase s of a cycle.
  const Piece<T>& find(double cycle, double s) const {
    const auto after = std::upper_bound(
        pieces_.begin(), pieces_.end(), s,
        [cycle](double at, const Piece<T>& p) { return cycle < p.cycle || (cycle == p.cycle && at < p.s); });
    return after == pieces_.begin() ? *after : *(after - 1);
  }
  Motion<T> at(const Piece<T>& piece, double s, const ScaledDrive<T>& drive, const T& kappa) const;

 private:
  Motion<T> inside_arc(const Piece<T>& piece, double t, const ScaledDrive<T>& drive, const T& kappa) const;
  void store(Piece<T> piece, int order, std::initializer_list<const T*> columns) {
    piece.order = order;
    piece.offset = pool_.size();
    for (const T* column : columns) pool_.insert(pool_.end(), column, column + order + 1);
    pieces_.push_back(piece);
  }

  std::vector<Piece<T>> pieces_;
  std::vector<T> pool_;
  std::vector<SlowStep<T>> slow_;
};

/// U and X from the integrals of the drive, exact, and of the polynomial through the directions.
template <class T>
Motion<T> PieceChain<T>::inside_arc(const Piece<T>& piece, double t, const ScaledDrive<T>& d,
                                    const T& kappa) const {
  double once[GaussTable::kMaxNodes], twice[GaussTable::kMaxNodes];
  const double h = piece.span;
  GaussTable::of_pairs(piece.order / 2).integrals_to(h > 0 ? t / h : 0, once, twice);
  Pair<T> first, second;
  const T* n = pool_.data() + piece.offset;
  for (int i = 0; i < piece.order; ++i) {
    add_multiple(first.x, h * once[i], n[2 * i]);
    add_multiple(first.y, h * once[i], n[2 * i + 1]);
    add_multiple(second.x, h * h * twice[i], n[2 * i]);
    add_multiple(second.y, h * h * twice[i], n[2 * i + 1]);
  }
  const double c0 = std::cos(piece.s), s0 = std::sin(piece.s), c = std::cos(piece.s + t),
               s = std::sin(piece.s + t);
  Motion<T> m{piece.velocity - kappa * first, piece.position - kappa * second};
  add_multiple(m.velocity, t, d.constant);
  add_multiple(m.velocity, s - s0, d.p);
  add_multiple(m.velocity, c0 - c, d.q);
  add_multiple(m.position, t, piece.velocity);
  add_multiple(m.position, 0.5 * t * t, d.constant);
  add_multiple(m.position, c0 - c - t * s0, d.p);
  add_multiple(m.position, s0 - s + t * c0, d.q);
  return m;
}

template <class T>
Motion<T> PieceChain<T>::at(const Piece<T>& piece, double s, const ScaledDrive<T>& drive,
                            const T& kappa) const {
  using std::cos;
  using std::sin;
  const int n = piece.order;
  switch (piece.kind) {
    case PieceKind::stick:
      break;
    case PieceKind::arc:
      return inside_arc(piece, std::clamp(s - piece.s, 0.0, piece.span), drive, kappa);
    case PieceKind::series: {
      const T* c = pool_.data() + piece.offset;
      const T t = std::clamp(s - piece.s, 0.0, piece.span) - piece.shift;
      return {{evaluate(c, n, t), evaluate(c + n + 1, n, t)},
              {piece.position.x + evaluate_integral(c, n, t),
               piece.position.y + evaluate_integral(c + n + 1, n, t)}};
    }
    case PieceKind::polar: {
      const T* c = pool_.data() + piece.offset;
      PolarSeries<T> series;
      series.order = n;
      T* columns[] = {series.log_speed, series.angle, series.s, series.x, series.y};
      for (T* column : columns) {
        std::copy(c, c + n + 1, column);
        c += n + 1;
      }
      const PolarState<T> state = series.at(series.solve(s, piece.span));
      return at_fixed_phase(state, drive, kappa);
    }
    case PieceKind::slow: {
      const auto p = slow_[piece.offset].at(std::clamp(s - piece.s, 0.0, piece.span));
      return {{p.speed * cos(p.angle), p.speed * sin(p.angle)}, {p.x, p.y}};
    }
  }
  return {{}, piece.position};
}

/// From derivatives at fixed sigma to derivatives at fixed s.
template <class T>
Motion<T> at_fixed_phase(const PolarState<T>& state, const ScaledDrive<T>& drive, const T& kappa) {
  using std::cos;
  using std::sin;
  const T moved = change(state.s);
  const Pair<T> u = state.velocity(), d = drive.at(value(state.s));
  const Pair<T> f{d.x - kappa * cos(state.angle), d.y - kappa * sin(state.angle)};
  return {u - moved * f, Pair<T>{state.x, state.y} - moved * u};
}

}  // namespace tribotrack::model::internal

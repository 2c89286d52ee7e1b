// Creeping slip, implicitly: where friction turns the velocity onto the drive faster than anything else
// changes.
#pragma once

#include <Eigen/LU>
#include <array>
#include <bitset>
#include <cmath>
#include <optional>

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

/// Nodes and matrices of Radau IIA collocation (Hairer & Wanner, Solving ODEs II, IV.5) in a Legendre basis.
struct Collocation {
  static constexpr int kStages = 10;
  using Square = Eigen::Matrix<double, kStages, kStages>;
  std::array<double, kStages> node;  ///< in (0, 1], the last is 1
  Square integrate;                  ///< values at the nodes -> integrals from 0 to the nodes
  Square to_legendre;                ///< values at the nodes -> coefficients of P_j(2c - 1)

  static const Collocation& get();
  /// Integrals of the P_j from 0 to c.
  static std::array<double, kStages> integrals(double c);
};

/// A step of dr/ds = d.n - kappa, r db/ds = d.n_perp with U = r (cos b, sin b). As r -> 0 the second equation
/// turns algebraic, which stiffly accurate collocation takes in its stride; r may start or end at exactly 0.
template <class T>
struct SlowStep {
  static constexpr int S = Collocation::kStages;
  double span = 0;
  T speed0{}, angle0{}, x0{}, y0{};
  std::array<T, S> speed_rate, angle_rate, velocity_x, velocity_y;  ///< Legendre coefficients
  bool stops = false;                                               ///< r = 0 at the end of the span

  struct Point {
    T speed, angle, x, y;
  };
  Point at(double t) const;
};

/// Solves one step over `span`, or with `to_stop` one up to the stop, `span` being a guess of when that
/// comes. nullopt when the step does not resolve the motion to `tolerance` (a transient still decaying, a
/// step too long) or its r does not stay positive.
template <class T>
std::optional<SlowStep<T>> slow_step(const ScaledDrive<T>& drive, const T& kappa, double s, double span,
                                     const T& speed0, T angle0, bool to_stop, double tolerance);

/// The equations' Jacobian by the rates, (1, upper; lower, corner): r' is explicit, so that only half of the
/// system has to be eliminated.
struct SlowJacobian {
  static constexpr int S = Collocation::kStages;
  Collocation::Square upper, lower;
  Eigen::PartialPivLU<Collocation::Square> schur;  ///< of corner - lower * upper

  template <int N>
  Eigen::Matrix<double, 2 * S, N> solve(const Eigen::Matrix<double, 2 * S, N>& right) const {
    using Half = Eigen::Matrix<double, S, N>;
    const Half first = right.template topRows<S>();
    const Half second = right.template bottomRows<S>() - lower.lazyProduct(first);
    Eigen::Matrix<double, 2 * S, N> x;
    x.template bottomRows<S>() = schur.solve(second);
    x.template topRows<S>() = first - upper.lazyProduct(x.template bottomRows<S>());
    return x;
  }
};

/// The solution at the nodes: rates of r and b.
struct SlowStages {
  static constexpr int S = Collocation::kStages;
  using Vector = Eigen::Matrix<double, 2 * S, 1>;
  Vector rates;           ///< (r', b') at the nodes
  SlowJacobian jacobian;  ///< at the solution
};
/// By Newton's method from the rates of `guess`, those of a span hardly different, where there is one.
std::optional<SlowStages> solve_stages(const ScaledDrive<double>& drive, double kappa, double s, double span,
                                       double speed0, double angle0, const SlowStages* guess);

template <class T>
typename SlowStep<T>::Point SlowStep<T>::at(double t) const {
  const auto weight = Collocation::integrals(t / span);
  Point p{speed0, angle0, x0, y0};
  for (int j = 0; j < S; ++j) {
    const double w = weight[j] * span;
    p.speed += speed_rate[j] * w;
    p.angle += angle_rate[j] * w;
    p.x += velocity_x[j] * w;
    p.y += velocity_y[j] * w;
  }
  return p;
}

/// Sizes of the last two Legendre coefficients of a function given at the nodes, and of the function.
struct Tail {
  double tail = 0, size = 0;
  void add(const Eigen::Matrix<double, Collocation::kStages, 1>& at_nodes) {
    const auto& c = Collocation::get();
    constexpr int S = Collocation::kStages;
    const Eigen::Matrix<double, Collocation::kStages, 1> coefficient = c.to_legendre * at_nodes;
    tail = std::fmax(tail, std::fabs(coefficient[S - 1]) + 0.1 * std::fabs(coefficient[S - 2]));
    size = std::fmax(size, at_nodes.template lpNorm<Eigen::Infinity>());
    if (!std::isfinite(coefficient[S - 1])) tail = HUGE_VAL;
  }
};

/// Derivatives of the stages: one Newton step in Jets on the converged values.
template <int N, class Stages>
bool differentiate(const std::array<Pair<Jet<N>>, Collocation::kStages>& d, const Jet<N>& kappa,
                   const SlowStages& stages, const Stages& r, const Stages& b, Stages& rate, Stages& turn) {
  constexpr int S = Collocation::kStages;
  Eigen::Matrix<double, 2 * S, N> residual;
  for (int i = 0; i < S; ++i) {
    const Jet<N> cosine = cos(b[i]), sine = sin(b[i]);
    const Jet<N> first = rate[i] - (d[i].x * cosine + d[i].y * sine - kappa);
    const Jet<N> second = r[i] * turn[i] - (d[i].y * cosine - d[i].x * sine);
    for (int j = 0; j < N; ++j) {
      residual(i, j) = first.d[j];
      residual(S + i, j) = second.d[j];
    }
  }
  const Eigen::Matrix<double, 2 * S, N> correction = stages.jacobian.solve<N>(residual);
  for (int i = 0; i < S; ++i)
    for (int j = 0; j < N; ++j) {
      rate[i].d[j] -= correction(i, j);
      turn[i].d[j] -= correction(S + i, j);
    }
  return correction.allFinite();
}

/// The derivatives whose acceleration's Legendre coefficients have not died out.
template <int N, class Stages>
std::bitset<N> find_unresolved(const Stages& r, const Stages& b, const Stages& rate, const Stages& turn,
                               double span, double tolerance) {
  constexpr int S = Collocation::kStages;
  std::array<Eigen::Matrix<double, S, 1>, N> ax, ay;
  for (int i = 0; i < S; ++i) {
    const Jet<N> cosine = cos(b[i]), sine = sin(b[i]), across = r[i] * turn[i];
    const Jet<N> fx = rate[i] * cosine - across * sine, fy = rate[i] * sine + across * cosine;
    for (int j = 0; j < N; ++j) {
      ax[j][i] = fx.d[j];
      ay[j][i] = fy.d[j];
    }
  }
  std::bitset<N> unresolved;
  for (int j = 0; j < N; ++j) {
    Tail derivative;
    derivative.add(ax[j]);
    derivative.add(ay[j]);
    unresolved[j] = !(derivative.tail * span <= 1e5 * tolerance * std::fmax(1.0, derivative.size));
  }
  return unresolved;
}

template <class T>
std::optional<SlowStep<T>> slow_step(const ScaledDrive<T>& drive, const T& kappa, double s, double span,
                                     const T& speed0, T angle0, bool to_stop, double tolerance) {
  using std::cos;
  using std::sin;
  constexpr int S = Collocation::kStages;
  constexpr int N = derivative_count<T>;
  const Collocation& c = Collocation::get();
  const ScaledDrive<double> plain = values(drive);
  const double longest = 2 * span;
  std::optional<SlowStages> stages;
  for (int i = 0;; ++i) {
    stages =
        solve_stages(plain, value(kappa), s, span, value(speed0), value(angle0), stages ? &*stages : nullptr);
    if (!stages) return std::nullopt;
    const auto rates = stages->rates.template head<S>();
    const Eigen::Matrix<double, S, 1> speed = (span * (c.integrate * rates)).array() + value(speed0);
    if (!to_stop && !(speed.minCoeff() > 0)) return std::nullopt;
    if (!to_stop || std::fabs(speed[S - 1]) <= 1e-17) {
      if (!(speed.template head<S - 1>().minCoeff() > 0)) return std::nullopt;
      break;
    }
    // Newton on the span until r ends at 0.
    if (i == 12 || !(rates[S - 1] < 0)) return std::nullopt;
    span -= speed[S - 1] / rates[S - 1];
    if (!(span > 0 && span <= longest)) return std::nullopt;
  }
  std::array<T, S> r, b, rate, turn;
  for (int j = 0; j < S; ++j) {
    rate[j] = T(stages->rates[j]);
    turn[j] = T(stages->rates[S + j]);
  }
  const auto sum_up = [&] {
    for (int i = 0; i < S; ++i) {
      r[i] = speed0;
      b[i] = angle0;
      for (int j = 0; j < S; ++j) {
        r[i] += rate[j] * (span * c.integrate(i, j));
        b[i] += turn[j] * (span * c.integrate(i, j));
      }
    }
  };
  sum_up();
  // Resolved? The acceleration's Legendre coefficients must have died out.
  Eigen::Matrix<double, S, 1> ax, ay;
  for (int i = 0; i < S; ++i) {
    const double cosine = std::cos(value(b[i])), sine = std::sin(value(b[i]));
    const double across = value(r[i]) * value(turn[i]);
    ax[i] = value(rate[i]) * cosine - across * sine;
    ay[i] = value(rate[i]) * sine + across * cosine;
  }
  Tail tail;
  tail.add(ax);
  tail.add(ay);
  if (!(tail.tail * span <= 20 * tolerance)) return std::nullopt;
  if constexpr (N > 0) {
    std::array<Pair<T>, S> d;
    for (int i = 0; i < S; ++i) d[i] = drive.at(s + span * c.node[i]);
    // Where r is so small that the angle settles before anything has moved, its change at the start is no
    // initial value: what the nodes see, which have settled, is carried back to the start, until the step
    // resolves it.
    for (int attempt = 0;; ++attempt) {
      if (!differentiate<N>(d, kappa, *stages, r, b, rate, turn)) return std::nullopt;
      sum_up();
      const std::bitset<N> unresolved = find_unresolved<N>(r, b, rate, turn, span, tolerance);
      if (unresolved.none()) break;
      if (attempt == 4) return std::nullopt;
      for (int j = 0; j < N; ++j) {
        if (!unresolved[j]) continue;
        double settled = 0;
        for (int k = 0; k < S; ++k)
          for (int i = 0; i < S; ++i) settled += (k % 2 == 0 ? 1 : -1) * c.to_legendre(k, i) * b[i].d[j];
        const double start = value(speed0), off = std::fabs(settled - angle0.d[j]);
        if (!(start * start * off <= 1e-13 * value(kappa) * std::fmax(1.0, std::fabs(speed0.d[j]))))
          return std::nullopt;
        angle0.d[j] = settled;
      }
      sum_up();
    }
  }

  std::array<T, S> vx, vy;
  for (int i = 0; i < S; ++i) {
    vx[i] = r[i] * cos(b[i]);
    vy[i] = r[i] * sin(b[i]);
  }
  SlowStep<T> step;
  step.span = span;
  step.speed0 = speed0;
  step.angle0 = angle0;
  step.stops = to_stop;
  for (int i = 0; i < S; ++i) {
    step.speed_rate[i] = step.angle_rate[i] = step.velocity_x[i] = step.velocity_y[i] = T(0.0);
    for (int j = 0; j < S; ++j) {
      const double w = c.to_legendre(i, j);
      step.speed_rate[i] += rate[j] * w;
      step.angle_rate[i] += turn[j] * w;
      step.velocity_x[i] += vx[j] * w;
      step.velocity_y[i] += vy[j] * w;
    }
  }
  return step;
}

}  // namespace tribotrack::model::internal

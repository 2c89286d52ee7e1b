// Creeping slip, implicitly: where friction turns the velocity onto the drive faster than anything else
// changes.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>

#include "model/internal/scaled_problem.h"

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

/// The solution at the nodes: rates of r and b.
struct SlowStages {
  static constexpr int S = Collocation::kStages;
  using Vector = Eigen::Matrix<double, 2 * S, 1>;
  Vector rates;                                                       ///< (r', b') at the nodes
  Eigen::PartialPivLU<Eigen::Matrix<double, 2 * S, 2 * S>> jacobian;  ///< at the solution
};
std::optional<SlowStages> solve_stages(const ScaledDrive<double>& drive, double kappa, double s, double span,
                                       double speed0, double angle0);

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

template <class T>
ScaledDrive<double> values(const ScaledDrive<T>& d) {
  return {
      {value(d.constant.x), value(d.constant.y)}, {value(d.p.x), value(d.p.y)}, {value(d.q.x), value(d.q.y)}};
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
    stages = solve_stages(plain, value(kappa), s, span, value(speed0), value(angle0));
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
  // Derivatives: one Newton step in Jets on the converged stages.
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
  if constexpr (N > 0) {
    // r b' = d.n_perp at the start: where r is so small that the angle settles before anything has moved, its
    // change is no initial value but follows from that (from u = 0 always).
    double turning = 0;
    for (int j = 0; j < S; ++j) {
      const double sign = j % 2 == 0 ? 1 : -1;  // P_j(-1)
      turning += sign * c.to_legendre.row(j).dot(stages->rates.template tail<S>());
    }
    const Pair<T> d = drive.at(s);
    const double cosine = std::cos(value(angle0)), sine = std::sin(value(angle0));
    const double along = value(d.x) * cosine + value(d.y) * sine;
    const T settled = change(T((d.y * cosine - d.x * sine - speed0 * turning) / along));
    for (int j = 0; j < N; ++j) {
      const double off = std::fabs(settled.d[j] - angle0.d[j]);
      const double start = value(speed0);
      if (start * start * off <= 1e-13 * along * std::fmax(1.0, std::fabs(speed0.d[j])))
        angle0.d[j] = settled.d[j];
    }
  }
  sum_up();
  if constexpr (N > 0) {
    Eigen::Matrix<double, 2 * S, N> residual;
    for (int i = 0; i < S; ++i) {
      const Pair<T> d = drive.at(s + span * c.node[i]);
      const T cosine = cos(b[i]), sine = sin(b[i]);
      const T first = rate[i] - (d.x * cosine + d.y * sine - kappa);
      const T second = r[i] * turn[i] - (d.y * cosine - d.x * sine);
      for (int j = 0; j < N; ++j) {
        residual(i, j) = first.d[j];
        residual(S + i, j) = second.d[j];
      }
    }
    const Eigen::Matrix<double, 2 * S, N> correction = stages->jacobian.solve(residual);
    for (int i = 0; i < S; ++i)
      for (int j = 0; j < N; ++j) {
        rate[i].d[j] = -correction(i, j);
        turn[i].d[j] = -correction(S + i, j);
      }
    sum_up();
  }

  // Resolved? The acceleration's Legendre coefficients must have died out, in the derivatives, too.
  Eigen::Matrix<double, S, 1> ax, ay;
  std::array<T, S> vx, vy, fx, fy;
  for (int i = 0; i < S; ++i) {
    const T cosine = cos(b[i]), sine = sin(b[i]);
    vx[i] = r[i] * cosine;
    vy[i] = r[i] * sine;
    fx[i] = rate[i] * cosine - vy[i] * turn[i];
    fy[i] = rate[i] * sine + vx[i] * turn[i];
    ax[i] = value(fx[i]);
    ay[i] = value(fy[i]);
  }
  Tail tail;
  tail.add(ax);
  tail.add(ay);
  if (!(tail.tail * span <= 20 * tolerance)) return std::nullopt;
  if constexpr (N > 0) {
    for (int j = 0; j < N; ++j) {
      Tail derivative;
      for (int i = 0; i < S; ++i) {
        ax[i] = fx[i].d[j];
        ay[i] = fy[i].d[j];
      }
      derivative.add(ax);
      derivative.add(ay);
      if (!(derivative.tail * span <= 1e5 * tolerance * std::fmax(1.0, derivative.size))) return std::nullopt;
    }
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

#include "model/series/creep.h"

namespace tribotrack::model::internal {
namespace {

constexpr int S = Collocation::kStages;

/// P_0 .. P_count-1 at x.
template <class Real>
void legendre(Real x, int count, Real* p) {
  p[0] = 1;
  if (count > 1) p[1] = x;
  for (int j = 1; j + 1 < count; ++j)
    p[j + 1] = (static_cast<Real>(2 * j + 1) * x * p[j] - static_cast<Real>(j) * p[j - 1]) /
               static_cast<Real>(j + 1);
}

/// Integrals of P_j(2c - 1) from 0 to c.
template <class Real>
void legendre_integrals(Real c, Real* integral) {
  Real p[S + 1];
  const Real x = 2 * c - 1;
  legendre(x, S + 1, p);
  integral[0] = c;
  for (int j = 1; j < S; ++j) integral[j] = (p[j + 1] - p[j - 1]) / static_cast<Real>(2 * (2 * j + 1));
}

Collocation make_collocation() {
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, S, S>;
  // The nodes are the roots of P_S - P_{S-1}; P_S - P_{S-1} changes sign between neighbouring roots.
  const auto f = [](Real x) {
    Real p[S + 1];
    legendre(x, S + 1, p);
    return p[S] - p[S - 1];
  };
  Collocation c;
  Real node[S];
  int found = 0;
  const int grid = 4000;
  for (int i = 0; i < grid && found < S - 1; ++i) {
    Real low = -1 + 2 * static_cast<Real>(i) / grid, high = -1 + 2 * static_cast<Real>(i + 1) / grid;
    const Real at_low = f(low);
    if (at_low * f(high) > 0) continue;
    for (int k = 0; k < 70; ++k) {
      const Real middle = (low + high) / 2;
      (at_low * f(middle) > 0 ? low : high) = middle;
    }
    node[found++] = (1 + (low + high) / 2) / 2;
  }
  node[S - 1] = 1;
  Matrix vandermonde, integrals;
  for (int i = 0; i < S; ++i) {
    Real p[S], q[S];
    legendre(2 * node[i] - 1, S, p);
    legendre_integrals(node[i], q);
    for (int j = 0; j < S; ++j) {
      vandermonde(i, j) = p[j];
      integrals(i, j) = q[j];
    }
    c.node[i] = static_cast<double>(node[i]);
  }
  const Matrix inverse = vandermonde.inverse();
  c.to_legendre = inverse.cast<double>();
  c.integrate = (integrals * inverse).cast<double>();
  return c;
}

}  // namespace

const Collocation& Collocation::get() {
  static const Collocation collocation = make_collocation();
  return collocation;
}

std::array<double, S> Collocation::integrals(double c) {
  std::array<double, S> integral;
  legendre_integrals(c, integral.data());
  return integral;
}

std::optional<SlowStages> solve_stages(const ScaledDrive<double>& drive, double kappa, double s, double span,
                                       double speed0, double angle0, const SlowStages* guess) {
  const Collocation& c = Collocation::get();
  std::array<Pair<double>, S> d;
  SlowStages stages;
  // First guess else: the velocity points along the drive.
  for (int i = 0; i < S; ++i) {
    const double at = s + span * c.node[i];
    d[i] = drive.at(at);
    const Pair<double> slope = drive.slope(at);
    const double norm = length(d[i]);
    if (!(norm > 0)) return std::nullopt;
    stages.rates[i] = norm - kappa;
    stages.rates[S + i] = (d[i].x * slope.y - d[i].y * slope.x) / (norm * norm);
  }
  if (guess) stages.rates = guess->rates;
  SlowJacobian& jacobian = stages.jacobian;
  Collocation::Square corner;
  SlowStages::Vector residual;
  const Collocation::Square weight = span * c.integrate;
  double last = HUGE_VAL;
  for (int iteration = 0; iteration < 15; ++iteration) {
    const Eigen::Matrix<double, S, 1> r = (weight * stages.rates.head<S>()).array() + speed0;
    const Eigen::Matrix<double, S, 1> b = (weight * stages.rates.tail<S>()).array() + angle0;
    for (int i = 0; i < S; ++i) {
      const double cosine = std::cos(b[i]), sine = std::sin(b[i]);
      const double along = d[i].x * cosine + d[i].y * sine, across = d[i].y * cosine - d[i].x * sine;
      residual[i] = stages.rates[i] - (along - kappa);
      residual[S + i] = r[i] * stages.rates[S + i] - across;
      jacobian.upper.row(i) = -across * weight.row(i);
      jacobian.lower.row(i) = stages.rates[S + i] * weight.row(i);
      corner.row(i) = along * weight.row(i);
      corner(i, i) += r[i];
    }
    jacobian.schur.compute(corner - jacobian.lower.lazyProduct(jacobian.upper));
    const SlowStages::Vector correction = jacobian.solve<1>(residual);
    stages.rates -= correction;
    // What counts is the angle, not its rate: near r = 0 rates are noisy, angles are not.
    const double change = (weight * correction.tail<S>()).lpNorm<Eigen::Infinity>() +
                          correction.head<S>().lpNorm<Eigen::Infinity>();
    if (!(change < 10)) return std::nullopt;
    if (change < 1e-15 || (iteration > 1 && change < 1e-12 && change >= 0.25 * last)) return stages;
    last = change;
  }
  return std::nullopt;
}

}  // namespace tribotrack::model::internal

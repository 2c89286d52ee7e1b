#include "model/series/creep.h"

#include <boost/math/special_functions/legendre.hpp>

namespace tribotrack::model::internal {
namespace {

constexpr int S = Collocation::kStages;

/// P_0 .. P_S at 2c - 1.
template <class Real>
std::array<Real, S + 1> legendre(Real c) {
  const Real x = 2 * c - 1;
  std::array<Real, S + 1> p{1, x};
  for (unsigned j = 1; j < S; ++j) p[j + 1] = boost::math::legendre_next(j, x, p[j], p[j - 1]);
  return p;
}

/// Integrals of P_0 .. P_S-1 from 0 to c.
template <class Real>
std::array<Real, S> legendre_integrals(Real c) {
  const std::array<Real, S + 1> p = legendre(c);
  std::array<Real, S> integral{c};
  for (int j = 1; j < S; ++j) integral[j] = (p[j + 1] - p[j - 1]) / static_cast<Real>(2 * (2 * j + 1));
  return integral;
}

Collocation make_collocation() {
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, S, S>;
  // Roots of P_S - P_S-1.
  constexpr Real node[S] = {0.0144124096488765486328L, 0.0743873897091960446359L,
                            0.176116656162995281863L,  0.309667579927637817060L,
                            0.461970401081010934883L,  0.618117234695294024639L,
                            0.762823015185039614683L,  0.881921021210001299808L,
                            0.963742187116790539059L,  1};
  Collocation c;
  Matrix vandermonde, integrals;
  for (int i = 0; i < S; ++i) {
    const auto p = legendre(node[i]);
    const auto q = legendre_integrals(node[i]);
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
  return legendre_integrals(c);
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

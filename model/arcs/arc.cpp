#include "model/arcs/arc.h"

#include <boost/math/special_functions/legendre.hpp>
#include <vector>

namespace tribotrack::model::internal {

namespace {

using Real = long double;

GaussTable make_table(int pairs) {
  const int n = 2 * pairs;
  GaussTable g{};
  g.pairs = pairs;
  Real x[GaussTable::kMaxNodes], weight[GaussTable::kMaxNodes];
  Real p[GaussTable::kMaxNodes][GaussTable::kMaxNodes + 2];
  Real a[GaussTable::kMaxNodes][GaussTable::kMaxNodes];
  const std::vector<Real> positive = boost::math::legendre_p_zeros<Real>(n);  // they lie symmetrically
  for (int i = 0; i < n; ++i) {
    x[i] = i < pairs ? -positive[pairs - 1 - i] : positive[i - pairs];
    for (int k = 0; k < n + 2; ++k) p[i][k] = boost::math::legendre_p(k, x[i]);
    weight[i] = (1 - x[i] * x[i]) / (static_cast<Real>(n * n) * p[i][n - 1] * p[i][n - 1]);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      // f = sum_k (2k + 1) (sum_j b_j P_k(x_j) f_j) P_k; the integral of P_k is (P_k+1 - P_k-1)/(2k + 1).
      a[i][j] = 0.5L * weight[j] * (x[i] + 1);
      for (int k = 1; k < n; ++k) a[i][j] += 0.5L * weight[j] * p[j][k] * (p[i][k + 1] - p[i][k - 1]);
      g.integrate[i][j] = static_cast<double>(a[i][j]);
    }
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      g.to_legendre[k][j] = static_cast<double>(static_cast<Real>(2 * k + 1) * weight[j] * p[j][k]);
  for (int i = 0; i < n; ++i) {
    const Real c = 0.5L * (1 + x[i]);
    g.node[i] = static_cast<double>(c);
    g.weight[i] = static_cast<double>(weight[i]);
    g.moment[i] = static_cast<double>(weight[i] * (1 - c));
  }
  for (int i = 0; i < pairs; ++i) {
    const int mirror = n - 1 - i;
    g.front[i] = g.node[i];
    g.mirror[i] = g.node[mirror];
    g.moment_front[i] = g.moment[i];
    g.moment_mirror[i] = g.moment[mirror];
    g.tail_front[i] = static_cast<double>(static_cast<Real>(2 * n - 1) * weight[i] * p[i][n - 1]);
    g.tail_mirror[i] = static_cast<double>(static_cast<Real>(2 * n - 1) * weight[mirror] * p[mirror][n - 1]);
    for (int j = 0; j < pairs; ++j) {
      g.even[j][i] = static_cast<double>(0.5L * (a[i][j] + a[i][n - 1 - j]));
      g.odd[j][i] = static_cast<double>(0.5L * (a[i][j] - a[i][n - 1 - j]));
    }
    g.even[i][pairs] = static_cast<double>(weight[i]);
  }
  g.front[pairs] = 1;
  return g;
}

/// Divisions would take most of the time of integrals_to.
struct Inverse {
  double of_integers[GaussTable::kMaxNodes + 3] = {}, of_integrals[GaussTable::kMaxNodes + 1] = {};
  constexpr Inverse() {
    for (int k = 1; k < GaussTable::kMaxNodes + 3; ++k) of_integers[k] = 1.0 / k;
    for (int k = 0; k <= GaussTable::kMaxNodes; ++k) of_integrals[k] = 1.0 / (4 * k + 2);
  }
};
constexpr Inverse kInverse;

}  // namespace

const GaussTable& GaussTable::of_pairs(int pairs) {
  static const GaussTable few = make_table(3), many = make_table(7);
  return pairs == 3 ? few : many;
}

void GaussTable::integrals_to(double c, double* once, double* twice) const {
  const int n = 2 * pairs;
  // The integral of P_k is (P_k+1 - P_k-1)/(4k + 2), that of P_0 is c.
  double p[kMaxNodes + 3], first[kMaxNodes + 2];
  const double x = 2 * c - 1;
  p[0] = 1;
  p[1] = x;
  for (int k = 1; k < n + 2; ++k)
    p[k + 1] = ((2 * k + 1) * x * p[k] - k * p[k - 1]) * kInverse.of_integers[k + 1];
  first[0] = c;
  for (int k = 1; k <= n; ++k) first[k] = (p[k + 1] - p[k - 1]) * kInverse.of_integrals[k];
  for (int j = 0; j < n; ++j) once[j] = twice[j] = 0;
  for (int k = 0; k < n; ++k) {
    const double second = k == 0 ? 0.5 * c * c : (first[k + 1] - first[k - 1]) * kInverse.of_integrals[k];
    for (int j = 0; j < n; ++j) {
      once[j] += to_legendre[k][j] * first[k];
      twice[j] += to_legendre[k][j] * second;
    }
  }
}

}  // namespace tribotrack::model::internal

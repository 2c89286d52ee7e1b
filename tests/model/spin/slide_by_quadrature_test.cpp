// A slide with spin by quadrature of the published friction integrals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/spinning_disc.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using std::numbers::pi;

/// Farkas, Bartels, Unger, Wolf, Phys. Rev. Lett. 90, 248302 (2003): force per mu m g and torque per mu m g R
/// of an evenly pressed disc at e = u/(omega R), in complete elliptic integrals K and E of the modulus.
test::FaceForce published(double e) {
  const double square = e * e;
  if (e == 1) return {8 / (3 * pi), 8 / (9 * pi)};  // K is infinite there, times 0
  if (e <= 1) {
    const double big_k = std::comp_ellint_1(e), big_e = std::comp_ellint_2(e);
    return {4 / (3 * pi * e) * ((square + 1) * big_e + (square - 1) * big_k),
            4 / (9 * pi) * ((4 - 2 * square) * big_e + (square - 1) * big_k)};
  }
  const double big_k = std::comp_ellint_1(1 / e), big_e = std::comp_ellint_2(1 / e);
  return {4 / (3 * pi) * ((square + 1) * big_e - (square - 1) * big_k),
          4 * e / (9 * pi) * ((4 - 2 * square) * big_e + (2 * square - 5 + 3 / square) * big_k)};
}

/// Nodes on (0, 1).
struct Gauss {
  static constexpr int kNodes = 20;
  std::array<double, kNodes> x{}, weight{};
  Gauss() {
    using Rule = boost::math::quadrature::gauss<double, kNodes>;  // its nodes above 0, on (-1, 1)
    for (std::size_t i = 0; i < kNodes; ++i) {
      const std::size_t k = i % (kNodes / 2);
      x[i] = (1 + (i == k ? 1 : -1) * Rule::abscissa()[k]) / 2;
      weight[i] = Rule::weights()[k] / 2;
    }
  }
  template <class Function>
  double integral(double from, double to, Function f) const {
    double sum = 0;
    for (std::size_t i = 0; i < kNodes; ++i) sum += weight[i] * f(from + (to - from) * x[i]);
    return (to - from) * sum;
  }
};

/// With D(e) = F(e) - e T(e)/k, k = I/(m R^2): u' = -mu g F and w' = -mu g T/k (w = omega R) make
///   d ln w = (T/k)/D de,  dt = -w/(mu g D) de,  dx = e w dt,  R dtheta = w dt,
/// from e_0 to the root e* of D, where both stop. In s = -ln|e - e*| all of it is smooth and decays. The
/// time, the way and the rim's way from speed 1 with mu g = 1.
struct WholeSlide {
  double last_ratio = 0, time = 0, way = 0, rim = 0;

  WholeSlide(double spin_ratio, double inertia) {
    const auto balance = [&](double e) {
      const test::FaceForce at = published(e);
      return at.force - e * at.torque / inertia;
    };
    double low = 1e-3, high = 1e3;
    for (int k = 0; k < 200; ++k) {
      const double middle = std::sqrt(low * high);
      (balance(middle) * balance(low) > 0 ? low : high) = middle;
    }
    last_ratio = std::sqrt(low * high);
    const double first = 1 / spin_ratio, span = first - last_ratio;
    const auto ratio = [&](double s) { return last_ratio + span * std::exp(-s); };
    const auto falls = [&](double s) {  // -d ln w/ds
      const double e = ratio(s);
      return published(e).torque / inertia / balance(e) * (e - last_ratio);
    };
    const Gauss gauss;
    // Panels of the same length, but for edges that crowd where u = w: (u - w) ln|u - w| in F and T.
    std::vector<double> edges;
    for (int k = 0; k <= 140; ++k) edges.push_back(0.2 * k);
    if (first > 1) {
      const double equal = -std::log((1 - last_ratio) / span);
      for (double off = 0.1; off > 1e-9; off /= 4)
        edges.insert(edges.end(), {equal - off, equal, equal + off});
    }
    std::sort(edges.begin(), edges.end());
    double fallen = 0;  // ln(w_0/w) at the panel's begin
    for (std::size_t k = 1; k < edges.size(); ++k) {
      const double from = edges[k - 1], to = edges[k];
      if (from < 0 || to <= from) continue;
      for (std::size_t i = 0; i < Gauss::kNodes; ++i) {
        const double s = from + (to - from) * gauss.x[i];
        const double w = spin_ratio * std::exp(-fallen - gauss.integral(from, s, falls));
        const double dt = (to - from) * gauss.weight[i] * w * (ratio(s) - last_ratio) / balance(ratio(s));
        time += dt;
        way += ratio(s) * w * dt;
        rim += w * dt;
      }
      fallen += gauss.integral(from, to, falls);
    }
  }
};

TEST(SlideByQuadrature, EvenDisc) {
  EXPECT_NEAR(WholeSlide(1, 0.5).last_ratio, 0.653, 5e-4);
  for (const double inertia : {0.5, 0.4})
    for (const double ratio : {0.2, 0.7, 1.0, 1.3, 4.0}) {
      SCOPED_TRACE("w/u " + std::to_string(ratio) + ", I/(m R^2) " + std::to_string(inertia));
      const WholeSlide exact(ratio, inertia);
      const double mu = 0.17, speed = 0.6, radius = 0.0155;
      Scenario s;
      s.drive.amplitude = s.drive.amplitude_y = 0;
      s.friction = {mu, 0, 0, 0, 0};
      s.initial_velocity = {0.8 * speed, 0.6 * speed};
      s.spin = {-ratio * speed / radius, radius, inertia};
      const double time_unit = speed / (mu * s.drive.gravity), way_unit = speed * time_unit;
      s.duration = 1.1 * exact.time * time_unit;
      const Trajectory run = integrate(s);
      EXPECT_NEAR((run.end_time() - run.summary().stick_time) / time_unit, exact.time, 1e-8);
      EXPECT_NEAR((run.end().position / way_unit - exact.way * Eigen::Vector2d(0.8, 0.6)).norm(), 0, 1e-11);
      EXPECT_NEAR(-run.end().angle * radius / way_unit, exact.rim, 1e-11);
    }
}

}  // namespace
}  // namespace tribotrack::model

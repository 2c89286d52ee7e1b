// Creeping in quadruple precision: u' = d - kappa u/|u| while |u| << kappa, where the direction relaxes at
// kappa/|u| and explicit methods hang. Chebyshev collocation of the Cartesian velocity over one long
// interval: the equation is demanded at 29 points at once. Whether the polynomial resolves the motion is read
// off its last coefficients; where it does not (a layer in which the direction still relaxes) nothing is
// returned.
#pragma once

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <optional>

#include "model/quad_drive.h"
#include "model/quad_math.h"

namespace tribotrack::model::reference {

struct QuadCreep {
  quad ux = 0, uy = 0, dx = 0, dy = 0;  ///< velocity at the end of the interval, way over it
};

class ChebyshevCreep {
 public:
  static constexpr int N = 28;  ///< degree

  /// Nodes c_i in [0, 1] from 0 to 1, derivatives and integral of the polynomial through values there.
  ChebyshevCreep() {
    for (int i = 0; i <= N; ++i) {
      quad sine, cosine;
      sine_cosine(pi() * i / N, sine, cosine);
      node_[i] = (1 - cosine) / 2;
      weight_[i] = (i % 2 == 0 ? 1 : -1) * (i == 0 || i == N ? quad(0.5) : quad(1));
      for (int k = 0; k <= N; ++k) {
        sine_cosine(pi() * i * k / N, sine, cosine);
        chebyshev_[k][i] = k % 2 == 0 ? cosine : -cosine;  // T_k at 2 c - 1 = -cos
      }
    }
    for (int i = 0; i <= N; ++i) {
      slope_[i][i] = 0;
      for (int j = 0; j <= N; ++j)
        if (j != i) {
          slope_[i][j] = weight_[j] / weight_[i] / (node_[i] - node_[j]);
          slope_[i][i] -= slope_[i][j];
        }
    }
  }

  std::optional<QuadCreep> over(const QuadDrive& drive, quad kappa, quad s, quad span, quad ux,
                                quad uy) const {
    using Matrix = Eigen::Matrix<long double, 2 * N, 2 * N>;
    using Vector = Eigen::Matrix<long double, 2 * N, 1>;
    Values dx, dy, x, y, size;
    guess(drive, kappa, s, span, ux, uy, dx, dy, x, y, size);
    const auto narrow = [](quad a) { return static_cast<long double>(a); };
    long double last = HUGE_VALL;
    for (int iteration = 0; iteration < 40; ++iteration) {
      // F = u' - d + kappa u/|u| at the nodes 1..N; unknowns in units of the guessed speed.
      Matrix jacobian = Matrix::Zero();
      Vector residual;
      for (int i = 1; i <= N; ++i) {
        quad rate_x = 0, rate_y = 0;
        for (int j = 0; j <= N; ++j) {
          rate_x += slope_[i][j] / span * x[j];
          rate_y += slope_[i][j] / span * y[j];
        }
        const quad r = square_root(x[i] * x[i] + y[i] * y[i]);
        if (!(r > 0)) return std::nullopt;
        const quad nx = x[i] / r, ny = y[i] / r;
        const int a = 2 * (i - 1), b = a + 1;
        residual[a] = narrow(rate_x - dx[i] + kappa * nx);
        residual[b] = narrow(rate_y - dy[i] + kappa * ny);
        for (int j = 1; j <= N; ++j)
          jacobian(a, 2 * (j - 1)) = jacobian(b, 2 * (j - 1) + 1) = narrow(slope_[i][j] / span * size[j]);
        const quad stiff = kappa * size[i] / r;
        jacobian(a, a) += narrow(stiff * ny * ny);
        jacobian(a, b) -= narrow(stiff * nx * ny);
        jacobian(b, a) -= narrow(stiff * nx * ny);
        jacobian(b, b) += narrow(stiff * nx * nx);
      }
      const Vector correction = jacobian.partialPivLu().solve(residual);
      const long double change = correction.template lpNorm<Eigen::Infinity>();
      if (!(change < 2)) return std::nullopt;
      for (int i = 1; i <= N; ++i) {
        x[i] -= size[i] * static_cast<quad>(correction[2 * (i - 1)]);
        y[i] -= size[i] * static_cast<quad>(correction[2 * (i - 1) + 1]);
      }
      // Until rounding: the equation's is 1e-33 of kappa, what is left of d and kappa may be 1e-12 of them.
      if (change < 1e-24L || (change < 1e-15L && change > 0.25L * last)) return result(span, x, y);
      if (iteration > 8 && change > 0.5L * last) return std::nullopt;
      last = change;
    }
    return std::nullopt;
  }

 private:
  using Values = std::array<quad, N + 1>;

  /// Along the drive, the speed by the trapezoidal rule on |d| - kappa.
  void guess(const QuadDrive& drive, quad kappa, quad s, quad span, quad ux, quad uy, Values& dx, Values& dy,
             Values& x, Values& y, Values& size) const {
    x[0] = ux;
    y[0] = uy;
    quad speed = square_root(ux * ux + uy * uy), before = 0;
    for (int i = 0; i <= N; ++i) {
      drive.at(s + span * node_[i], dx[i], dy[i]);
      const quad norm = square_root(dx[i] * dx[i] + dy[i] * dy[i]), rate = norm - kappa;
      if (i > 0) {
        const quad gain = span * (node_[i] - node_[i - 1]) * (rate + before) / 2;
        speed = speed + gain > speed / 4 ? speed + gain : speed / 4;
        x[i] = speed * dx[i] / norm;
        y[i] = speed * dy[i] / norm;
      }
      size[i] = speed;
      before = rate;
    }
  }

  /// The end of the polynomial if its last coefficients have fallen to 1e-16 of the largest.
  std::optional<QuadCreep> result(quad span, const Values& x, const Values& y) const {
    QuadCreep end{x[N], y[N], 0, 0};
    double largest = 0, last = 0;
    for (int k = 0; k <= N; ++k) {
      quad cx = 0, cy = 0;
      for (int i = 0; i <= N; ++i) {
        const quad w = absolute(weight_[i]) * chebyshev_[k][i];
        cx += w * x[i];
        cy += w * y[i];
      }
      cx *= (k == 0 || k == N ? quad(1) : quad(2)) / N;
      cy *= (k == 0 || k == N ? quad(1) : quad(2)) / N;
      const double size = static_cast<double>(absolute(cx) + absolute(cy));
      largest = size > largest ? size : largest;
      if (k > N - 4) last = size > last ? size : last;
      if (k % 2 == 0) {  // the integral of T_k over [-1, 1] is 2/(1 - k^2)
        end.dx += span * cx / (1 - k * k);
        end.dy += span * cy / (1 - k * k);
      }
    }
    if (!(last < 1e-16 * largest)) return std::nullopt;
    return end;
  }

  std::array<quad, N + 1> node_, weight_;
  std::array<std::array<quad, N + 1>, N + 1> slope_, chebyshev_;
};

}  // namespace tribotrack::model::reference

#include "vision/layered_split.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vision/bspline.h"

namespace tribotrack::vision {
namespace {

constexpr int kPad = 4;            ///< coefficients beyond the grid
constexpr int kRounds = 10;        ///< overlapping rings share what they take out: one round leaves a part
constexpr double kEnough = 1e-10;  ///< of the first residual's square

using Vector = Eigen::VectorXf;

/// Where pixel u of the grid lies in the turning picture: its six by six coefficients and their weights.
struct Taps {
  std::size_t first = 0;
  std::array<float, 6> x{}, y{};
};

class Problem {
 public:
  Problem(const std::vector<TurnedPicture>& pictures, const Picture& cover, double ridge)
      : pictures_(pictures), cover_(cover), ridge_(static_cast<float>(ridge)) {
    size_ = cover.width();
    stride_ = size_ + 2 * kPad;
    pixels_ = static_cast<std::size_t>(size_) * size_;
    coefficients_ = static_cast<std::size_t>(stride_) * stride_;
    for (std::size_t k = 0; k < pixels_; ++k)
      if (cover_.levels()[k] > 0) covered_.push_back(k);
  }
  std::size_t unknowns() const { return pixels_ + coefficients_; }
  std::size_t pixels() const { return pixels_; }

  /// out = A^T W A v.
  void apply(const Vector& v, Vector& out) const {
    accumulate(
        out,
        [&](const TurnedPicture&, std::size_t k, float turning) {
          return v(static_cast<Eigen::Index>(k)) + turning;
        },
        v);
  }
  /// The same with the ridge.
  void normal(const Vector& v, Vector& out) const {
    apply(v, out);
    out.tail(static_cast<Eigen::Index>(coefficients_)) +=
        ridge_ * v.tail(static_cast<Eigen::Index>(coefficients_));
    // Pixels never seen: hold them where they are.
    out.head(static_cast<Eigen::Index>(pixels_)) += 1e-3F * v.head(static_cast<Eigen::Index>(pixels_));
  }
  /// out = A^T W data.
  void right(Vector& out) const {
    const Vector none = Vector::Zero(static_cast<Eigen::Index>(unknowns()));
    accumulate(
        out, [](const TurnedPicture& p, std::size_t k, float) { return p.level.levels()[k]; }, none);
  }

  /// The standing picture that goes with the turning one: the mean of what is left.
  void fit_standing(Vector& v) const {
    const auto n = static_cast<Eigen::Index>(pixels_);
    Vector without = v;
    without.head(n).setZero();
    Vector turning, all;
    apply(without, turning);
    right(all);
    for (std::size_t k = 0; k < pixels_; ++k) {
      double weight = 0;
      for (const TurnedPicture& p : pictures_) weight += p.weight.levels()[k];
      const auto i = static_cast<Eigen::Index>(k);
      if (weight > 0) v(i) = static_cast<float>((all(i) - turning(i)) / weight);
    }
  }

  /// The spline at the grid's own pixels.
  Picture at_pixels(const Vector& v) const {
    Picture out(size_, size_);
    for (int y = 0; y < size_; ++y)
      for (int x = 0; x < size_; ++x) out.at(x, y) = gather(v, taps(x, y));
    return out;
  }

  /// Takes the first harmonic out of every ring of the turning picture beyond a radius.
  void make_round(Vector& v, double from) const {
    struct Ring {
      double n = 0, c = 0, s = 0;
    };
    std::vector<Ring> rings(static_cast<std::size_t>(stride_));
    const double half = 0.5 * (stride_ - 1);
    const auto each = [&](const auto& act) {
      for (int y = 0; y < stride_; ++y)
        for (int x = 0; x < stride_; ++x) {
          const double rho = std::hypot(x - half, y - half);
          if (rho < from - 1 || rho > half) continue;
          const auto ring = static_cast<std::size_t>(rho);
          act(v(static_cast<Eigen::Index>(pixels_) + static_cast<Eigen::Index>(y) * stride_ + x),
              (x - half) / rho, (y - half) / rho, ring, rho - static_cast<double>(ring), rho);
        }
    };
    // Rings overlap linearly.
    each([&](float value, double c, double s, std::size_t ring, double t, double) {
      for (const auto& [k, w] : {std::pair{ring, 1 - t}, std::pair{ring + 1, t}}) {
        rings[k].n += 0.5 * w;
        rings[k].c += w * c * value;
        rings[k].s += w * s * value;
      }
    });
    each([&](float& value, double c, double s, std::size_t ring, double t, double rho) {
      const double fade = std::clamp(rho - from + 1, 0.0, 1.0);
      for (const auto& [k, w] : {std::pair{ring, 1 - t}, std::pair{ring + 1, t}})
        if (rings[k].n > 0)
          value -= static_cast<float>(fade * w * (rings[k].c * c + rings[k].s * s) / rings[k].n);
    });
  }

 private:
  Taps taps(double x, double y) const {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    Taps t;
    const auto wx = quintic_weights(x - fx);
    const auto wy = quintic_weights(y - fy);
    for (std::size_t i = 0; i < 6; ++i) {
      t.x[i] = static_cast<float>(wx[i]);
      t.y[i] = static_cast<float>(wy[i]);
    }
    t.first = pixels_ + static_cast<std::size_t>(static_cast<int>(fy) - 2 + kPad) * stride_ +
              static_cast<std::size_t>(static_cast<int>(fx) - 2 + kPad);
    return t;
  }
  float gather(const Vector& v, const Taps& t) const {
    float sum = 0;
    for (std::size_t j = 0; j < 6; ++j) {
      const float* row = v.data() + t.first + j * stride_;
      float line = 0;
      for (std::size_t i = 0; i < 6; ++i) line += t.x[i] * row[i];
      sum += t.y[j] * line;
    }
    return sum;
  }
  void scatter(Vector& v, const Taps& t, float value) const {
    for (std::size_t j = 0; j < 6; ++j) {
      float* row = v.data() + t.first + j * stride_;
      for (std::size_t i = 0; i < 6; ++i) row[i] += value * t.y[j] * t.x[i];
    }
  }
  /// out = sum over pictures and pixels of A^T W value(picture, pixel, cover * turning(v) there).
  template <typename Value>
  void accumulate(Vector& out, const Value& value, const Vector& v) const {
    out.setZero(static_cast<Eigen::Index>(unknowns()));
    const double half = 0.5 * (size_ - 1);
    for (const TurnedPicture& p : pictures_) {
      const double c = std::cos(p.theta);
      const double s = std::sin(p.theta);
      for (std::size_t k = 0; k < pixels_; ++k)
        if (cover_.levels()[k] <= 0)
          out(static_cast<Eigen::Index>(k)) += p.weight.levels()[k] * value(p, k, 0.0F);
      for (const std::size_t k : covered_) {
        const float weight = p.weight.levels()[k];
        if (weight == 0) continue;
        const double x = static_cast<double>(k % static_cast<std::size_t>(size_)) - half;
        const double y = static_cast<double>(k / static_cast<std::size_t>(size_)) - half;
        const Taps t = taps(half + c * x - s * y, half + s * x + c * y);
        const float cover = cover_.levels()[k];
        const float g = weight * value(p, k, cover * gather(v, t));
        out(static_cast<Eigen::Index>(k)) += g;
        scatter(out, t, cover * g);
      }
    }
  }

  const std::vector<TurnedPicture>& pictures_;
  const Picture& cover_;
  float ridge_ = 0;
  int size_ = 0, stride_ = 0;
  std::size_t pixels_ = 0, coefficients_ = 0;
  std::vector<std::size_t> covered_;
};

}  // namespace

void split_turning(const std::vector<TurnedPicture>& pictures, const Picture& cover, double ridge,
                   double round_from, int iterations, StandingAndTurning& known) {
  const Problem problem(pictures, cover, ridge);
  const auto n = static_cast<Eigen::Index>(problem.unknowns());
  Vector v = Vector::Zero(n);
  std::copy(known.standing.levels().begin(), known.standing.levels().end(), v.data());
  if (known.coefficients.size() == problem.unknowns() - problem.pixels())
    std::copy(known.coefficients.begin(), known.coefficients.end(), v.data() + problem.pixels());
  Vector applied, residual;
  problem.right(residual);
  problem.normal(v, applied);
  residual -= applied;
  Vector direction = residual;
  double square = residual.cast<double>().squaredNorm();
  const double enough = kEnough * square;
  for (int k = 0; k < iterations && square > enough; ++k) {
    problem.normal(direction, applied);
    const double curvature = direction.cast<double>().dot(applied.cast<double>());
    if (!(curvature > 0)) break;
    const auto step = static_cast<float>(square / curvature);
    v += step * direction;
    residual -= step * applied;
    const double next = residual.cast<double>().squaredNorm();
    direction = residual + static_cast<float>(next / square) * direction;
    square = next;
  }
  for (int k = 0; k < kRounds; ++k) problem.make_round(v, round_from);
  problem.fit_standing(v);
  std::copy_n(v.data(), problem.pixels(), known.standing.levels().begin());
  known.coefficients.assign(v.data() + problem.pixels(), v.data() + problem.unknowns());
  known.turning = problem.at_pixels(v);
}

}  // namespace tribotrack::vision

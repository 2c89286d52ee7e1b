#include "vision/layers/model/split.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/kernels/bspline.h"
#include "vision/layers/model/split_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kPad = 4;            ///< coefficients beyond the grid
constexpr int kRounds = 10;        ///< overlapping rings share what they take out: one round leaves a part
constexpr double kEnough = 1e-10;  ///< of the first residual's square

using Vector = Eigen::VectorXf;

/// Neighbouring pixels of a row that something turning covers.
struct Run {
  std::size_t first = 0;
  int count = 0;
};

class Problem {
 public:
  Problem(const std::vector<TurnedPicture>& pictures, const Picture& cover, double ridge)
      : pictures_(pictures), cover_(cover), ridge_(static_cast<float>(ridge)) {
    size_ = cover.width();
    stride_ = size_ + 2 * kPad;
    pixels_ = static_cast<std::size_t>(size_) * size_;
    coefficients_ = static_cast<std::size_t>(stride_) * stride_;
    for (std::size_t k = 0; k < pixels_; ++k) {
      if (cover_.levels()[k] <= 0) continue;
      const bool goes_on = !covered_.empty() && k % static_cast<std::size_t>(size_) > 0 &&
                           covered_.back().first + static_cast<std::size_t>(covered_.back().count) == k;
      if (!goes_on) covered_.push_back({k, 0});
      ++covered_.back().count;
    }
  }
  std::size_t unknowns() const { return pixels_ + coefficients_; }
  std::size_t pixels() const { return pixels_; }

  /// out = A^T W A v.
  void apply(const Vector& v, Vector& out) const { accumulate(out, &v); }
  /// The same with the ridge.
  void normal(const Vector& v, Vector& out) const {
    apply(v, out);
    out.tail(static_cast<Eigen::Index>(coefficients_)) +=
        ridge_ * v.tail(static_cast<Eigen::Index>(coefficients_));
    // Pixels never seen: hold them where they are.
    out.head(static_cast<Eigen::Index>(pixels_)) += 1e-3F * v.head(static_cast<Eigen::Index>(pixels_));
  }
  /// out = A^T W data.
  void right(Vector& out) const { accumulate(out, nullptr); }

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
    const SplineTaps whole = spline_taps(0, 0);
    for (int y = 0; y < size_; ++y)
      for (int x = 0; x < size_; ++x) {
        const float* c = v.data() + coefficient(x - 2, y - 2);
        for (std::size_t j = 0; j < 6; ++j)
          for (std::size_t i = 0; i < 6; ++i)
            out.at(x, y) +=
                whole.weight_y[j] * whole.weight_x[i] * c[j * static_cast<std::size_t>(stride_) + i];
      }
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
  /// Where the coefficient of a pixel is among the unknowns.
  std::ptrdiff_t coefficient(int x, int y) const {
    return static_cast<std::ptrdiff_t>(pixels_) + static_cast<std::ptrdiff_t>(y + kPad) * stride_ +
           (x + kPad);
  }
  /// out = sum over pictures and pixels of A^T W A v; of A^T W data without v.
  void accumulate(Vector& out, const Vector* v) const {
    out.setZero(static_cast<Eigen::Index>(unknowns()));
    const double half = 0.5 * (size_ - 1);
    for (const TurnedPicture& p : pictures_) {
      const float* given = v ? v->data() : p.level.levels().data();
      const float* weight = p.weight.levels().data();
      for (std::size_t k = 0; k < pixels_; ++k)
        if (cover_.levels()[k] <= 0) out(static_cast<Eigen::Index>(k)) += weight[k] * given[k];
      const double c = std::cos(p.theta), s = std::sin(p.theta);
      SplitRow row;
      row.origin = (v ? v->data() : out.data()) + coefficient(0, 0);
      row.sums = out.data() + coefficient(0, 0);
      row.stride = stride_;
      row.c = static_cast<float>(c);
      row.s = static_cast<float>(s);
      for (const Run& run : covered_) {
        const double x = static_cast<double>(run.first % static_cast<std::size_t>(size_)) - half;
        const double y = static_cast<double>(run.first / static_cast<std::size_t>(size_)) - half;
        row.x = static_cast<float>(half + c * x - s * y);
        row.y = static_cast<float>(half + s * x + c * y);
        row.cover = cover_.levels().data() + run.first;
        row.weight = weight + run.first;
        row.given = given + run.first;
        row.standing = out.data() + run.first;
        row.count = run.count;
        split_kernels().add(row, v != nullptr);
      }
    }
  }

  const std::vector<TurnedPicture>& pictures_;
  const Picture& cover_;
  float ridge_ = 0;
  int size_ = 0, stride_ = 0;
  std::size_t pixels_ = 0, coefficients_ = 0;
  std::vector<Run> covered_;
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

#include "model/lanes/shooting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/equation/matrix2.h"
#include "model/lanes/turning_frame.h"
#include "model/processor/kernels.h"

namespace tribotrack::model::internal {
namespace {

constexpr int kParts = SlideLanes::kWidth;
constexpr int kMostSteps = 24, kMostIterations = 14;
/// Tolerance of each step, first and last.
constexpr double kLoosest = 1e-4, kTightest = 1e-14;
/// Where no more than this is left the next iteration is to be the last but one at most.
constexpr double kNearlyThere = 1e-7;
/// Newton steps leave this share of themselves: their Jacobian is off by as much.
constexpr double kRough = 1e-2, kSharp = 1e-3;
/// What may be left of the velocity.
constexpr double kDone = 2e-15;
/// Slower parts are about to stop.
constexpr double kTooSlow = 0.01;
/// No start is moved by more than this share of its speed at once.
constexpr double kFarthest = 0.7;
/// Cycles that hardly contract magnify what the lanes leave.
constexpr double kHardlyContracts = 0.9;

/// A stretch of the cycle at one friction.
struct Stretch {
  double from, span;
  bool reduced;
  int parts = 1;
};

/// From the local phase 0 round; parts about as long everywhere.
class Cut {
 public:
  explicit Cut(const Edges<double>& edges) {
    bool reduced = edges.open_at_start;
    double from = 0;
    for (const Edge<double>& edge : edges.edge) {
      add(from, edge.s, reduced);
      from = edge.s;
      reduced = edge.opens;
    }
    add(from, kTwoPi, reduced);
    for (int spare = kParts - count_; spare > 0; --spare)
      ++std::max_element(stretches_.begin(), stretches_.begin() + count_, [](const auto& a, const auto& b) {
          return a.span / a.parts < b.span / b.parts;
        })->parts;
  }
  /// visit(part, from, span, reduced)
  template <class Visit>
  void each_part(const Visit& visit) const {
    int part = 0;
    for (int i = 0; i < count_; ++i) {
      const Stretch& s = stretches_[static_cast<std::size_t>(i)];
      for (int k = 0; k < s.parts; ++k, ++part)
        visit(part, s.from + s.span * k / s.parts, s.span / s.parts, s.reduced);
    }
  }

 private:
  void add(double from, double to, bool reduced) {
    if (to > from) stretches_[static_cast<std::size_t>(count_++)] = {from, to - from, reduced};
  }
  std::array<Stretch, 3> stretches_{};
  int count_ = 0;
};

class Shooting {
 public:
  explicit Shooting(const TurningFrame& frame) {
    double impulse = 0;
    Cut(frame.edges).each_part([&](int i, double from, double span, bool reduced) {
      lanes_.kappa[i] = frame.kappa(reduced);
      span_[i] = span;
      end_[i] = from + span;
      impulse += lanes_.kappa[i] * span;
    });
    // The circle at the mean friction.
    const double mean = std::fmin(impulse / kTwoPi, 0.9), r = std::sqrt((1 - mean) * (1 + mean));
    for (auto& v : start_) v = {r * mean, -r * r};
  }

  bool converges() {
    double tolerance = kLoosest;
    for (iterations_ = 1; iterations_ <= kMostIterations; ++iterations_) {
      if (!carry(tolerance)) return false;
      newton();
      if (!std::isfinite(size_)) return false;
      const double left = size_ * std::max(size_, tolerance > 1e-6 ? kRough : kSharp);
      if (tolerance <= kTightest && left <= kDone) return spectral_radius(cycle_) < kHardlyContracts;
      for (int i = 0; i < kParts; ++i) start_[i] = start_[i] + share_ * step_[i];
      tolerance = left < kNearlyThere ? kTightest : std::clamp(1e-2 * left, kTightest, kLoosest);
    }
    return false;
  }

  Pair<double> velocity() const { return start_[0] + step_[0]; }
  Pair<double> drift() const {
    Pair<double> sum;
    for (int i = 0; i < kParts; ++i) {
      const Matrix2 slope{lanes_.yx[0][i], lanes_.yx[1][i], lanes_.yy[0][i], lanes_.yy[1][i]};
      const Pair<double> z = Pair<double>{lanes_.zx[i], lanes_.zy[i]} + slope * step_[i];
      const double c = std::cos(end_[i]), s = std::sin(end_[i]);
      sum = sum + Pair<double>{z.x * c - z.y * s, z.x * s + z.y * c};
    }
    return sum;
  }
  double contraction() const { return spectral_radius(cycle_); }
  int iterations() const { return iterations_; }

 private:
  /// All parts from their starts to their ends; false where one takes too many steps.
  bool carry(double tolerance) {
    for (int i = 0; i < kParts; ++i) {
      lanes_.left[i] = span_[i];
      lanes_.tolerance[i] = tolerance;
      lanes_.vx[i] = start_[i].x;
      lanes_.vy[i] = start_[i].y;
      lanes_.zx[i] = lanes_.zy[i] = 0;
      lanes_.ux[0][i] = lanes_.uy[1][i] = 1;
      lanes_.ux[1][i] = lanes_.uy[0][i] = 0;
      for (int k = 0; k < 2; ++k) lanes_.yx[k][i] = lanes_.yy[k][i] = 0;
    }
    for (int n = 0; n < kMostSteps; ++n) {
      kernel_(lanes_);
      double left = 0, slowest = HUGE_VAL;
      for (int i = 0; i < kParts; ++i) {
        left = std::fmax(left, lanes_.left[i]);
        slowest = std::fmin(slowest, lanes_.vx[i] * lanes_.vx[i] + lanes_.vy[i] * lanes_.vy[i]);
      }
      if (left == 0) return true;
      if (slowest < kTooSlow * kTooSlow) return false;
    }
    return false;
  }

  Matrix2 dependence(int i) const {
    return {lanes_.ux[0][i], lanes_.ux[1][i], lanes_.uy[0][i], lanes_.uy[1][i]};
  }

  /// Part i + 1 is to begin where part i ends: step[i+1] = U_i step[i] + gap_i, and round.
  void newton() {
    Pair<double> gap[kParts], sum;
    cycle_ = Matrix2{};
    for (int i = 0; i < kParts; ++i) {
      gap[i] = Pair<double>{lanes_.vx[i], lanes_.vy[i]} - start_[(i + 1) % kParts];
      sum = dependence(i) * sum + gap[i];
      cycle_ = dependence(i) * cycle_;
    }
    step_[0] = newton_step(cycle_, sum);
    size_ = 0;
    share_ = 1;
    for (int i = 0; i < kParts; ++i) {
      if (i > 0) step_[i] = dependence(i - 1) * step_[i - 1] + gap[i - 1];
      const double size = length(step_[i]);
      size_ = std::isfinite(size) ? std::fmax(size_, size) : HUGE_VAL;
      share_ = std::fmin(share_, kFarthest * length(start_[i]) / size);
    }
  }

  SlideStep kernel_ = kernels().slides.slide.with_neighbours;
  SlideLanes lanes_{};
  double span_[kParts] = {}, end_[kParts] = {};
  Pair<double> start_[kParts], step_[kParts];
  Matrix2 cycle_;
  double size_ = 0, share_ = 1;
  int iterations_ = 0;
};

}  // namespace

std::optional<SteadyOrbit> shoot(const Scenario& scenario) {
  const auto frame = turning_frame(scenario);
  if (!frame || frame->edges.count == 0 || frame->kappa_nominal == frame->kappa_reduced) return std::nullopt;
  Shooting shooting(*frame);
  if (!shooting.converges()) return std::nullopt;
  SteadyOrbit orbit;
  orbit.velocity = scenario.drive.angular_frequency * frame->in_metres(shooting.velocity());
  orbit.phase = scenario.start_phase;
  orbit.drift = frame->in_metres(shooting.drift());
  orbit.contraction = shooting.contraction();
  orbit.newton_iterations = shooting.iterations();
  return orbit;
}

std::optional<TurningFrame> turning_frame(const Scenario& scenario) {
  const SolverInput<double> in = set_up<double>(scenario, {});
  const auto& drive = in.problem.drive;
  const double a = length(drive.p), size = a * a;
  const bool round = a > 0 && drive.constant.x == 0 && drive.constant.y == 0 &&
                     std::fabs(dot(drive.q, drive.q) - size) <= 4e-15 * size &&
                     std::fabs(dot(drive.p, drive.q)) <= 2e-15 * size;
  if (!round) return std::nullopt;
  TurningFrame f;
  f.kappa_nominal = in.problem.kappa_nominal / a;
  f.kappa_reduced = in.problem.kappa_reduced / a;
  f.edges = in.edges;
  f.circling = in.circling;
  f.cycles = in.cycles;
  f.rest = in.rest;
  f.length = a * in.problem.velocity_unit / scenario.drive.angular_frequency;
  f.cosine = drive.p.x / a;
  f.sine = drive.p.y / a;
  f.sense = drive.p.x * drive.q.y - drive.p.y * drive.q.x > 0 ? 1 : -1;
  const Pair<double> u = in.velocity;
  f.velocity = {(u.x * f.cosine + u.y * f.sine) / a, f.sense * (u.y * f.cosine - u.x * f.sine) / a};
  return f;
}

}  // namespace tribotrack::model::internal

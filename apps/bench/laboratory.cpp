#include "apps/bench/laboratory.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <string_view>

#include "fit/conditions.h"
#include "fit/estimate.h"
#include "model/parallel.h"

namespace tribotrack::bench {

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr int kSteps = 2000;  ///< a turn
constexpr std::array kErrors{AlphaVErrors{0.002, 0.002}, AlphaVErrors{pi / 180, 0.02},
                             AlphaVErrors{2.9 * pi / 180, 0.057}};

/// Integral from -infinity of a ramp from 0 to 1 about 0, `rise` long.
double ramp_integral(double x, double rise) {
  if (rise <= 0 || std::abs(x) >= rise / 2) return std::max(x, 0.0);
  return (x + rise / 2) * (x + rise / 2) / (2 * rise);
}

/// The share of mu2 in mu, integrated over wt up to a constant.
class Gate {
 public:
  Gate(double opens, double width, double rise) : opens_(opens), width_(width), rise_(rise) {}
  double integral(double wt) const {
    const double turns = std::floor((wt - opens_) / (2 * pi)), into = wt - opens_ - 2 * pi * turns;
    return turns * width_ + of_one(into) + of_one(into - 2 * pi);  // the next may begin before its edge
  }

 private:
  double of_one(double wt) const { return ramp_integral(wt, rise_) - ramp_integral(wt - width_, rise_); }
  double opens_, width_, rise_;
};

}  // namespace

Vector2d stepped(const Laboratory& lab, const model::Scenario& s, double mu1, double mu2) {
  const double w = s.drive.angular_frequency, g = s.drive.gravity, a = s.drive.amplitude;
  const double dt = 2 * pi / w / kSteps, fading = lab.fading * a * w;
  const Gate gate(s.friction.phase + lab.lag, s.friction.pulse_width, lab.edges);
  const Vector2d pull(g * std::sin(lab.tilt_x), g * std::sin(lab.tilt_y));
  const double a_x = a / std::sqrt(lab.ratio), a_y = a * std::sqrt(lab.ratio);
  Vector2d x = Vector2d::Zero(), u = x;
  double before = gate.integral(0);
  for (int k = 0; k < static_cast<int>(s.cycles) * kSteps; ++k) {
    const double wt = (k + 0.5) * w * dt, after = gate.integral((k + 1) * w * dt);
    const double reduced = (after - before) / (w * dt), speed = u.norm();
    before = after;
    const Vector2d push =
        pull +
        w * w * Vector2d(a_x * std::cos(wt), a_y * std::cos(wt + s.drive.phase_shift + lab.epsilon_error));
    const double mu =
        (mu1 + (mu2 - mu1) * reduced) * (1 + lab.stribeck * std::exp(-speed * speed / (fading * fading))) +
        lab.viscous * speed / g;
    const double most = mu * g * dt;
    const Vector2d free = u + dt * push;
    Vector2d next = free.norm() <= most ? Vector2d(0, 0) : Vector2d(free * (1 - most / free.norm()));
    if (speed > 2 * most)  // of second order where it slides: along the mean velocity
      for (int i = 0; i < 4; ++i) next = free - most * (0.5 * (u + next)).normalized();
    x += dt * 0.5 * (u + next);
    u = next;
  }
  return x;
}

fit::Problem campaign_of(const Laboratory& lab, const AlphaVErrors& errors, Dice& dice) {
  constexpr int kRuns = 14;
  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1, fit::FitParameter::mu2, fit::FitParameter::lag};
  for (int k = 0; k < kRuns; ++k) {
    fit::SummaryRun run;
    run.name = "run" + std::to_string(k);
    const double course = static_cast<double>(k) / (kRuns - 1) - 0.5;
    model::Scenario& s = run.scenario;
    s.cycles = 20;
    s.friction.phase = k < 8 ? k * pi / 4 : 0;
    s.friction.pulse_width = k < 8 ? pi / 3 : (k - 7) * pi / 6 + (k > 8 ? 0.5 : 0);
    model::Scenario truth = s;
    if (k == lab.bad_run) truth.friction.phase += 0.7;
    const double factor = (1 + lab.scatter * dice.normal()) * (1 + lab.wear * course);
    const double warm = 1 + lab.heating * (s.friction.pulse_width - pi / 3);
    const Vector2d moved = stepped(lab, truth, lab.mu1 * factor, lab.mu2 * factor * warm);
    const double v = moved.norm() / s.end_time(), off = lab.true_over_stated;
    const double alpha = std::atan2(moved.y(), moved.x()) + off * errors.alpha * dice.normal();
    const double seen = v * (1 + off * errors.v * dice.normal());
    run.measured = fit::displacement_from_alpha_v({alpha, errors.alpha}, {seen, errors.v * v},
                                                  s.drive.angular_frequency, static_cast<int>(s.cycles));
    problem.summary_runs.push_back(run);
  }
  return problem;
}

void take_nothing_as_exact(fit::Problem& problem) {
  constexpr double kDigit = 0.5 / std::numbers::sqrt3;  // sd of a value rounded to a digit
  fit::SharedEvidence shared;
  shared.tilt_x_sd = shared.tilt_y_sd = 2e-3;
  shared.amplitude_ratio_sd = 0.01;
  shared.phase_shift_sd = pi / 180;
  shared.law_is_exact = false;
  shared.assumed = {fit::Source::amplitude, fit::Source::angular_frequency, fit::Source::tilt_x,
                    fit::Source::tilt_y};
  shared.fitted = problem.free;
  std::vector<fit::RunEvidence> runs;
  std::vector<fit::RunConditions> start;
  for (const fit::SummaryRun& run : problem.summary_runs) {
    const model::Drive& drive = run.scenario.drive;
    fit::RunEvidence evidence;
    evidence.amplitude = {{drive.amplitude, kDigit * 1e-5}};
    evidence.angular_frequency = {{drive.angular_frequency, 1e-4 * drive.angular_frequency}};
    evidence.phi = {run.scenario.friction.phase, 0};
    evidence.dtau = {run.scenario.friction.pulse_width, 0};
    evidence.start_assumed = false;
    runs.push_back(evidence);
    start.emplace_back().drive = drive;
  }
  put_into(problem, pool(runs, shared, start));
}

namespace {

Laboratory drawn(std::string_view fault, Dice& dice) {
  const double mu1 = dice.uniform(0.06, 0.16);
  Laboratory lab{.mu1 = mu1, .mu2 = mu1 / dice.uniform(4, 12), .lag = dice.uniform(-0.5, 0.5)};
  const auto either = [&](double low, double high) {
    const double size = dice.uniform(low, high);
    return dice.normal() < 0 ? -size : size;
  };
  const auto tilt = [&](double size) {
    const double direction = dice.uniform(0, 2 * pi);
    lab.tilt_x = size * std::cos(direction);
    lab.tilt_y = size * std::sin(direction);
  };
  if (fault == "the usual") {
    tilt(1e-3 * std::abs(dice.normal()));
    lab.ratio = 1 + 0.01 * dice.normal();
    lab.epsilon_error = pi / 180 * dice.normal();
    lab.edges = dice.uniform(0, 0.2);
    lab.stribeck = dice.uniform(0, 0.15);
    lab.heating = dice.uniform(0, 0.1) * 3 / pi;
    lab.scatter = dice.uniform(0, 0.03);
    lab.true_over_stated = dice.uniform(0.7, 1.5);
  }
  if (fault == "tilt") tilt(dice.uniform(5e-3, 1e-2));
  if (fault == "amplitude_ratio") lab.ratio = 1 + either(0.03, 0.06);
  if (fault == "phase_shift") lab.epsilon_error = either(0.05, 0.1);
  if (fault == "stribeck") lab.stribeck = dice.uniform(0.25, 0.5);
  if (fault == "mu2_width") lab.heating = dice.uniform(0.1, 0.3);
  if (lab.stribeck > 0) lab.fading = dice.uniform(0.1, 0.5);
  if (fault == "wear") lab.wear = either(0.06, 0.13);
  if (fault == "bad_run") lab.bad_run = static_cast<int>(dice.uniform(0, 14));
  if (fault == "run_scatter") lab.scatter = dice.uniform(0.024, 0.048);
  return lab;
}

/// How far outside, as a share of the length of all pieces; 0 inside.
double outside(const std::vector<fit::Interval>& pieces, double value) {
  double off = INFINITY, length = 0;
  for (const fit::Interval& piece : pieces) {
    off = std::min(off, std::max({0.0, piece.low - value, value - piece.high}));
    length += piece.high - piece.low;
  }
  return off == 0 ? 0 : off / length;
}

LaboratoryRow judged(const char* fault, const AlphaVErrors& errors, Dice dice) {
  const Laboratory lab = drawn(fault, dice);
  fit::Problem problem = campaign_of(lab, errors, dice);
  take_nothing_as_exact(problem);
  LaboratoryRow row{fault, errors, 1};
  const fit::FitResult result = fit::estimate(problem, {.next_experiment = false});
  row.use = result.verdict == fit::Use::use;
  row.care = result.verdict == fit::Use::care;
  row.rejected = result.p_value < 1e-3;
  if (row.rejected > 0 && !result.explanations.empty())
    row.named = result.explanations.front().name == fault ||
                std::ranges::any_of(result.explanations,
                                    [&](const fit::Explanation& e) { return e.explains && e.name == fault; });
  if (!result.usable()) return row;
  const std::array truth{lab.mu1, lab.mu2, lab.lag};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool turns = i == 2;
    const auto pieces = quoted_pieces(result.parameters[i]);
    ++row.intervals;
    if (holds(pieces, truth[i], turns)) {
      ++row.held;
      continue;
    }
    const double near = turns ? result.parameters[i].estimate +
                                    std::remainder(truth[i] - result.parameters[i].estimate, 2 * pi)
                              : truth[i];
    if (row.use > 0 && outside(pieces, near) > 0.25) row.wrong = 1;
  }
  return row;
}

}  // namespace

std::vector<LaboratoryRow> laboratory(const BenchOptions& options) {
  constexpr std::uint64_t kSeed = 20261127;
  const int campaigns = std::max(1, options.campaigns.value_or(options.quick ? 1 : 200) / 20);
  struct Work {
    std::size_t row;
    int campaign;
  };
  std::vector<LaboratoryRow> rows;
  std::vector<Work> work;
  for (const char* fault : kFaults)
    for (const AlphaVErrors& errors : kErrors) {
      if (options.quick && &errors != &kErrors[1]) continue;
      for (int k = 0; k < campaigns; ++k) work.push_back({rows.size(), k});
      rows.push_back({fault, errors});
    }
  int done = 0;
  std::mutex mutex;
  parallel_for(work.size(), options.threads, [&](std::size_t i) {
    LaboratoryRow& row = rows[work[i].row];
    const LaboratoryRow one = judged(row.fault.c_str(), row.errors,
                                     Dice(kSeed, static_cast<std::uint32_t>(work[i].row), work[i].campaign));
    const std::lock_guard lock(mutex);
    for (int LaboratoryRow::*count :
         {&LaboratoryRow::campaigns, &LaboratoryRow::use, &LaboratoryRow::care, &LaboratoryRow::intervals,
          &LaboratoryRow::held, &LaboratoryRow::wrong, &LaboratoryRow::rejected, &LaboratoryRow::named})
      row.*count += one.*count;
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  return rows;
}

}  // namespace tribotrack::bench

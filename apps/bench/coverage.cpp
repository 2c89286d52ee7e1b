#include "apps/bench/coverage.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#include "apps/bench/peers.h"
#include "fit/estimate.h"
#include "model/parallel.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr double kFine = 1e-9;        ///< of the integrator, relative to A and A w: far below any noise
constexpr long kMostSteps = 100'000;  ///< a run takes some thousand where the integrator does not hang
constexpr double kTiltSd = pi / 1800;
constexpr double kFrameRate = 240;  ///< of slides, Hz

/// The peer's integrator did not come to an end.
struct PeerHangs {};

struct Noise {
  double alpha, v;              ///< rad; relative
  double amplitude, frequency;  ///< relative, of A and w where they are measured
};
Noise noise_of(NoiseLevel level) {
  return level == NoiseLevel::low ? Noise{pi / 180, 0.02, 0.01, 0.001}
                                  : Noise{2.9 * pi / 180, 0.057, 0.03, 0.003};
}

bool with_tilt(Design design) {
  return design == Design::tilt_unknown || design == Design::sticking_with_tilt;
}

model::Scenario draw_truth(Design design, Dice& dice) {
  model::Scenario truth;
  const model::Drive& drive = truth.drive;
  const double threshold =
      drive.amplitude * drive.angular_frequency * drive.angular_frequency / drive.gravity;
  const double least = design == Design::sticking_with_tilt ? 1.03 * threshold : 0.05;
  const double mu1 = dice.uniform(least, 0.16), ratio = dice.uniform(4, 12), lag = dice.uniform(-0.5, 0.5);
  truth.friction = {mu1, mu1 / ratio, 0, 0, lag};
  if (with_tilt(design)) {
    truth.drive.tilt_x = kTiltSd * dice.normal();
    truth.drive.tilt_y = kTiltSd * dice.normal();
  }
  return truth;
}

using Pulses = std::vector<std::pair<double, double>>;  ///< phi, dtau

Pulses random_pulses(int count, Dice& dice) {
  Pulses pulses;
  for (int k = 0; k < count; ++k) {
    const double phi = dice.uniform(0, 2 * pi);
    pulses.emplace_back(phi, dice.uniform(0.5, pi));
  }
  return pulses;
}

Pulses pulses_of(Design design, Dice& dice) {
  const int random = design == Design::three_runs   ? 3
                     : design == Design::five_runs  ? 5
                     : design == Design::eight_runs ? 8
                     : design == Design::repeats    ? 4
                                                    : 0;
  if (random > 0) {
    const Pulses settings = random_pulses(random, dice);
    Pulses pulses = settings;
    for (int again = 1; design == Design::repeats && again < 3; ++again)
      pulses.insert(pulses.end(), settings.begin(), settings.end());
    return pulses;
  }
  const double dtau = dice.uniform(0.6, 1.6), phi = dice.uniform(0, 2 * pi);
  Pulses pulses;
  for (int k = 0; k < 8; ++k) pulses.emplace_back(k * pi / 4, dtau);
  if (design != Design::phi_only)
    for (int k = 1; k <= 6; ++k) pulses.emplace_back(phi, k * pi / 6);
  return pulses;
}

/// Displacement over the time of the run's own cycles, m/s.
Vector2d independent_mean_velocity(const model::Scenario& scenario) {
  const PeerResult end = dormand_prince(scenario, kFine, kMostSteps);
  if (!end.finished) throw PeerHangs();
  return end.position / scenario.end_time();
}

/// What whoever fits is told of the truth.
model::Scenario without_friction(model::Scenario truth) {
  truth.friction.nominal = truth.friction.reduced = 0.05;
  truth.friction.lag = truth.drive.tilt_x = truth.drive.tilt_y = 0;
  return truth;
}

/// alpha and v of one run with their errors at the truth, under the conditions given.
SummaryRun filmed(const model::Scenario& truth, const model::Scenario& given, const Noise& noise,
                  std::size_t number, Dice& dice) {
  const Vector2d velocity = independent_mean_velocity(truth);
  const double speed = velocity.norm(),
               least = 1e-6 / truth.end_time();  // a micrometre in all, where it hardly moves
  const double v_sd = noise.v * speed + least, alpha_sd = noise.alpha + least / (speed + least);
  const Vector2d along = speed > 0 ? velocity.normalized() : Vector2d::UnitX(), across(-along.y(), along.x());
  // One after the other: compilers differ in which operand of a sum they evaluate first.
  const double off_across = alpha_sd * std::max(speed, v_sd) * dice.normal();
  const double off_along = v_sd * dice.normal();
  const Vector2d seen = velocity + off_along * along + off_across * across;
  const double alpha = std::atan2(seen.y(), seen.x());
  SummaryRun run;
  run.name = "run" + std::to_string(number);
  run.scenario = given;
  run.scenario.friction.phase = truth.friction.phase;
  run.scenario.friction.pulse_width = truth.friction.pulse_width;
  run.measured =
      displacement_from_alpha_v({alpha < 0 ? alpha + 2 * pi : alpha, alpha_sd}, {seen.norm(), v_sd},
                                given.drive.angular_frequency, static_cast<int>(truth.cycles));
  return run;
}

CoverageCampaign film(Design design, NoiseLevel level, const model::Scenario& truth, const Pulses& pulses,
                      Dice& dice) {
  const Noise noise = noise_of(level);
  CoverageCampaign campaign;
  Problem& problem = campaign.problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  campaign.truth = {truth.friction.nominal, truth.friction.reduced, truth.friction.lag};
  model::Scenario given = without_friction(truth);
  if (with_tilt(design)) {
    problem.free.insert(problem.free.end(), {FitParameter::tilt_x, FitParameter::tilt_y});
    campaign.truth.insert(campaign.truth.end(), {truth.drive.tilt_x, truth.drive.tilt_y});
  }
  if (design == Design::conditions_measured) {
    const double a = given.drive.amplitude, w = given.drive.angular_frequency;
    given.drive.amplitude = given.drive.amplitude_y = a * (1 + noise.amplitude * dice.normal());
    given.drive.angular_frequency = w * (1 + noise.frequency * dice.normal());
    problem.conditions = {{FitParameter::amplitude, a * noise.amplitude, "drawn"},
                          {FitParameter::angular_frequency, w * noise.frequency, "drawn"}};
  }
  for (const auto& [phi, dtau] : pulses) {
    model::Scenario scenario = truth;
    scenario.friction.phase = phi;
    scenario.friction.pulse_width = dtau;
    problem.summary_runs.push_back(filmed(scenario, given, noise, problem.summary_runs.size() + 1, dice));
  }
  return campaign;
}

void add_point(TrackTable& track, double time, const Vector2d& position, double sigma) {
  track.frame.push_back(static_cast<std::int64_t>(track.time.size()));
  track.time.push_back(time);
  track.position.push_back(position);
  track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
}

/// A slide without spin: s = v t - mu g t^2/2 until it stops.
struct Parabola {
  double mu, speed, gravity;
  double stop() const { return speed / (mu * gravity); }
  double way(double t) const {
    t = std::min(t, stop());
    return speed * t - 0.5 * mu * gravity * t * t;
  }
};

CoverageCampaign draw_slides(NoiseLevel level, Dice& dice) {
  const bool low = level == NoiseLevel::low;
  const double sigma = low ? 20e-6 : 60e-6, between = low ? 0.01 : 0.04;
  CoverageCampaign campaign;
  campaign.problem.free = {FitParameter::mu1};
  const double mu1 = dice.uniform(0.1, 0.25);
  campaign.truth = {mu1};
  const int count = static_cast<int>(dice.uniform(3, 9));
  for (int k = 0; k < count; ++k) {
    TrajectoryRun run;
    run.name = "slide" + std::to_string(k + 1);
    run.free_slide = true;
    run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
    run.track.radius = 15.5e-3;
    const Parabola slide{mu1 * (1 + between * dice.normal()), dice.uniform(0.4, 0.8),
                         run.scenario.drive.gravity};
    const double angle = dice.uniform(0, 2 * pi);
    const Vector2d way(std::cos(angle), std::sin(angle));
    for (int i = 0; i / kFrameRate < slide.stop() + 0.05; ++i) {
      const double t = i / kFrameRate;
      add_point(run.track, t, slide.way(t) * way + sigma * dice.normal_pair(), sigma);
    }
    campaign.problem.trajectory_runs.push_back(run);
  }
  return campaign;
}

template <class Draw>
CoverageCampaign draw_until_it_runs(const Draw& draw) {
  for (;;) try {
      return draw();
    } catch (const PeerHangs&) {
    }
}

}  // namespace

const char* to_string(Design design) {
  constexpr const char* names[] = {"both sweeps",  "phi only",         "3 runs",
                                   "5 runs",       "8 runs",           "repeats",
                                   "tilt unknown", "A and w measured", "sticking, tilt unknown",
                                   "slides"};
  static_assert(std::size(names) == kDesigns.size());
  return names[static_cast<std::size_t>(design)];
}

const char* to_string(NoiseLevel level) {
  return level == NoiseLevel::low ? "low" : "high";
}

CoverageCampaign draw_campaign(Design design, NoiseLevel level, std::uint64_t seed, int index) {
  Dice dice(seed, 2 * static_cast<std::uint32_t>(design) + (level == NoiseLevel::high), index);
  if (design == Design::slides) return draw_slides(level, dice);
  return draw_until_it_runs([&] {
    const model::Scenario truth = draw_truth(design, dice);
    return film(design, level, truth, pulses_of(design, dice), dice);
  });
}

CoverageCampaign draw_random_runs(int runs, NoiseLevel level, std::uint64_t seed, int index) {
  Dice dice(seed, 1000 + static_cast<std::uint32_t>(runs), index);
  return draw_until_it_runs([&] {
    const model::Scenario truth = draw_truth(Design::five_runs, dice);
    return film(Design::five_runs, level, truth, random_pulses(runs, dice), dice);
  });
}

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

bool is_open(const std::vector<Interval>& pieces, bool turns) {
  double width = 0;
  for (const Interval& piece : pieces) width += piece.high - piece.low;
  return !std::isfinite(width) || (turns && width >= kTurn * (1 - 1e-9));
}

/// One campaign's contribution to its rows, which are one for each parameter.
std::vector<CoverageRow> judge(Design design, NoiseLevel level, const CoverageCampaign& campaign) {
  std::vector<CoverageRow> rows;
  for (const FitParameter parameter : campaign.problem.free)
    rows.push_back({design, level, fit::to_string(parameter), 1});
  FitOptions options;
  options.next_experiment = false;
  FitResult result;
  try {
    result = estimate(campaign.problem, options);
  } catch (const std::exception&) {
    return rows;  // not usable
  }
  if (!result.usable()) return rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const bool turns = p.parameter == FitParameter::lag;
    const auto pieces = quoted_pieces(p);
    rows[i].usable = 1;
    rows[i].weak = result.identifiability.verdict == Verdict::weak;
    rows[i].open = is_open(pieces, turns);
    rows[i].covered = holds(pieces, campaign.truth[i], turns);
  }
  return rows;
}

}  // namespace

Interval binomial_ci95(int hits, int trials) {
  using Binomial = boost::math::binomial_distribution<>;
  return {Binomial::find_lower_bound_on_p(trials, hits, 0.025),
          Binomial::find_upper_bound_on_p(trials, hits, 0.025)};
}

Interval CoverageRow::share_ci95() const {
  return binomial_ci95(covered, usable);
}

std::vector<Interval> quoted_pieces(const ParameterEstimate& parameter) {
  if (parameter.ci95_pieces.size() > 1) return {parameter.ci95_pieces.begin(), parameter.ci95_pieces.end()};
  return {parameter.ci95};
}

bool holds(const std::vector<Interval>& pieces, double value, bool turns) {
  return std::ranges::any_of(pieces, [&](const Interval& piece) {
    const double from = piece.low;
    const double near =
        turns && std::isfinite(from) ? value + kTurn * std::ceil((from - value) / kTurn) : value;
    return from <= near && near <= piece.high;
  });
}

std::vector<CoverageRow> coverage(const BenchOptions& options) {
  constexpr std::uint64_t kSeed = 20210701;
  const int campaigns = options.campaigns.value_or(options.quick ? 2 : 200);
  struct Work {
    Design design;
    NoiseLevel level;
    int campaign;
    std::vector<CoverageRow> judged = {};
  };
  std::vector<Work> work;
  for (const Design design : kDesigns)
    for (const NoiseLevel level : kNoiseLevels)
      for (int k = 0; k < campaigns; ++k) work.push_back({design, level, k});
  int done = 0;
  std::mutex mutex;
  parallel_for(work.size(), options.threads, [&](std::size_t i) {
    auto& [design, level, k, judged] = work[i];
    judged = judge(design, level, draw_campaign(design, level, kSeed, k));
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  std::vector<CoverageRow> rows;
  for (const Work& one : work)
    for (const CoverageRow& more : one.judged) {
      auto row = std::ranges::find_if(rows, [&](const CoverageRow& r) {
        return r.design == more.design && r.level == more.level && r.parameter == more.parameter;
      });
      if (row == rows.end()) row = rows.insert(rows.end(), {more.design, more.level, more.parameter});
      row->campaigns += more.campaigns;
      row->usable += more.usable;
      row->weak += more.weak;
      row->open += more.open;
      row->covered += more.covered;
    }
  return rows;
}

}  // namespace tribotrack::bench

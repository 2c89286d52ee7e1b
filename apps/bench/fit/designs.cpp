#include "apps/bench/fit/designs.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "apps/bench/fit/information.h"
#include "apps/bench/peers/baselines.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr double kFine = 1e-9;        ///< of the integrator, relative to A and A w: far below any noise
constexpr long kMostSteps = 100'000;  ///< a run takes some thousand where the integrator does not hang
constexpr double kTiltSd = pi / 1800;

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
  switch (design) {
    case Design::three_runs:
      return random_pulses(3, dice);
    case Design::five_runs:
      return random_pulses(5, dice);
    case Design::eight_runs:
      return random_pulses(8, dice);
    case Design::repeats: {
      const Pulses settings = random_pulses(4, dice);
      Pulses pulses;
      for (int again = 0; again < 3; ++again) pulses.insert(pulses.end(), settings.begin(), settings.end());
      return pulses;
    }
    default:
      break;
  }
  const double dtau = dice.uniform(0.6, 1.6), phi = dice.uniform(0, 2 * pi);
  Pulses pulses;
  for (int k = 0; k < 8; ++k) pulses.emplace_back(k * pi / 4, dtau);
  if (design != Design::phi_only)
    for (int k = 1; k <= 6; ++k) pulses.emplace_back(phi, k * pi / 6);
  return pulses;
}

/// Displacement over the time of the run's own cycles, m/s.
Vector2d mean_velocity(const model::Scenario& scenario) {
  model::IntegrationOptions end_only;
  end_only.dense = false;
  return model::integrate(scenario, end_only).end().position / scenario.end_time();
}

Vector2d independent_mean_velocity(const model::Scenario& scenario) {
  DormandPrinceOptions options = segmented_dormand_prince(scenario, kFine);
  options.max_steps = kMostSteps;
  const PeerResult end = dormand_prince(scenario, options);
  if (!end.finished) throw PeerHangs();
  return end.position / scenario.end_time();
}

/// alpha and v of one run, and their errors at the truth.
struct Filmed {
  model::Scenario truth;
  Vector2d velocity;
  double alpha_sd = 0, v_sd = 0;

  Filmed(const model::Scenario& scenario, const Noise& noise)
      : truth(scenario), velocity(independent_mean_velocity(scenario)) {
    const double least = 1e-6 / scenario.end_time();  // a micrometre in all, where it hardly moves
    v_sd = noise.v * velocity.norm() + least;
    alpha_sd = noise.alpha + least / (velocity.norm() + least);
  }
  Displacement measured(double angular_frequency, Dice& dice) const {
    // One after the other: compilers differ in which operand of a sum they evaluate first.
    const double off_across = across_sd() * dice.normal();
    const double off_along = v_sd * dice.normal();
    const Vector2d seen = velocity + off_along * along() + off_across * across();
    const double alpha = std::atan2(seen.y(), seen.x());
    return displacement_from_alpha_v({alpha < 0 ? alpha + 2 * pi : alpha, alpha_sd}, {seen.norm(), v_sd},
                                     angular_frequency, static_cast<int>(truth.cycles));
  }
  Eigen::VectorXd whitened(const Vector2d& v) const {
    return Vector2d(along().dot(v) / v_sd, across().dot(v) / across_sd());
  }

 private:
  Vector2d along() const { return velocity.norm() > 0 ? velocity.normalized() : Vector2d::UnitX(); }
  Vector2d across() const { return {-along().y(), along().x()}; }
  double across_sd() const { return alpha_sd * std::max(velocity.norm(), v_sd); }
};

std::vector<Unknown> friction_unknowns(const model::Scenario& truth) {
  return {{[](model::Scenario& s, double by) { s.friction.nominal += by; }, 1e-5 * truth.friction.nominal},
          {[](model::Scenario& s, double by) { s.friction.reduced += by; }, 1e-5 * truth.friction.reduced},
          {[](model::Scenario& s, double by) { s.friction.lag += by; }, 1e-5}};
}

/// A and w are known to the sd of their measurement.
std::vector<Unknown> measured_conditions(const model::Scenario& truth, const Noise& noise) {
  const double w = truth.drive.angular_frequency;
  return {{[](model::Scenario& s, double by) {
             s.drive.amplitude *= 1 + by;
             s.drive.amplitude_y *= 1 + by;
           },
           1e-6, noise.amplitude},
          {[](model::Scenario& s, double by) { s.drive.angular_frequency += by; }, 1e-6 * w,
           noise.frequency * w}};
}

std::vector<Unknown> tilts() {
  return {{[](model::Scenario& s, double by) { s.drive.tilt_x += by; }, 1e-6},
          {[](model::Scenario& s, double by) { s.drive.tilt_y += by; }, 1e-6}};
}

/// What whoever fits is told of the truth.
model::Scenario without_friction(model::Scenario truth) {
  truth.friction.nominal = truth.friction.reduced = 0.05;
  truth.friction.lag = truth.drive.tilt_x = truth.drive.tilt_y = 0;
  return truth;
}

SummaryRun run_of(const Filmed& filmed, model::Scenario given, int number, Dice& dice) {
  SummaryRun run;
  run.name = "run" + std::to_string(number);
  given.friction.phase = filmed.truth.friction.phase;
  given.friction.pulse_width = filmed.truth.friction.pulse_width;
  run.scenario = given;
  run.measured = filmed.measured(given.drive.angular_frequency, dice);
  return run;
}

CoverageCampaign film(Design design, NoiseLevel level, const model::Scenario& truth, const Pulses& pulses,
                      Dice& dice) {
  const Noise noise = noise_of(level);
  CoverageCampaign campaign;
  Problem& problem = campaign.problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  campaign.truth = {truth.friction.nominal, truth.friction.reduced, truth.friction.lag};
  std::vector<Unknown> unknowns = friction_unknowns(truth);
  const auto also = [&](const std::vector<Unknown>& more) {
    unknowns.insert(unknowns.end(), more.begin(), more.end());
  };
  model::Scenario given = without_friction(truth);
  if (with_tilt(design)) {
    problem.free.insert(problem.free.end(), {FitParameter::tilt_x, FitParameter::tilt_y});
    campaign.truth.insert(campaign.truth.end(), {truth.drive.tilt_x, truth.drive.tilt_y});
    also(tilts());
  }
  const std::size_t reported = campaign.truth.size();
  if (design == Design::conditions_measured) {
    const double a = given.drive.amplitude, w = given.drive.angular_frequency;
    given.drive.amplitude = given.drive.amplitude_y = a * (1 + noise.amplitude * dice.normal());
    given.drive.angular_frequency = w * (1 + noise.frequency * dice.normal());
    problem.conditions = {{FitParameter::amplitude, a * noise.amplitude, "drawn"},
                          {FitParameter::angular_frequency, w * noise.frequency, "drawn"}};
    also(measured_conditions(truth, noise));
  }
  std::vector<Filmed> filmed;
  std::vector<model::Scenario> runs;
  for (const auto& [phi, dtau] : pulses) {
    model::Scenario scenario = truth;
    scenario.friction.phase = phi;
    scenario.friction.pulse_width = dtau;
    filmed.emplace_back(scenario, noise);
    runs.push_back(scenario);
    problem.summary_runs.push_back(run_of(filmed.back(), given, static_cast<int>(runs.size()), dice));
  }
  campaign.bound = cramer_rao(runs, unknowns, reported, [&](std::size_t k, const model::Scenario& scenario) {
    return filmed[k].whitened(mean_velocity(scenario));
  });
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
  switch (design) {
    case Design::both_sweeps:
      return "both sweeps";
    case Design::phi_only:
      return "phi only";
    case Design::three_runs:
      return "3 runs";
    case Design::five_runs:
      return "5 runs";
    case Design::eight_runs:
      return "8 runs";
    case Design::repeats:
      return "repeats";
    case Design::tilt_unknown:
      return "tilt unknown";
    case Design::conditions_measured:
      return "A and w measured";
    case Design::sticking_with_tilt:
      return "sticking, tilt unknown";
    case Design::slides:
      return "slides";
    case Design::trajectories:
      return "trajectories";
  }
  return "";
}

const char* to_string(NoiseLevel level) {
  return level == NoiseLevel::low ? "low" : "high";
}

CoverageCampaign draw_campaign(Design design, NoiseLevel level, std::uint64_t seed, int index) {
  Dice dice(seed, 2 * static_cast<std::uint32_t>(design) + (level == NoiseLevel::high), index);
  if (design == Design::slides) return draw_slides(level, dice);
  return draw_until_it_runs([&] {
    const model::Scenario truth = draw_truth(design, dice);
    if (design == Design::trajectories) return draw_trajectories(level, truth, dice);
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

SimulatedLab::SimulatedLab(NoiseLevel level, std::uint64_t seed, int index)
    : level_(level),
      dice_(seed, 1000 + static_cast<std::uint32_t>(level), index),
      truth_(draw_truth(Design::both_sweeps, dice_)) {}

SummaryRun SimulatedLab::film(double phi, double dtau) {
  model::Scenario scenario = truth_;
  scenario.friction.phase = phi;
  scenario.friction.pulse_width = dtau;
  return run_of(Filmed(scenario, noise_of(level_)), without_friction(truth_), ++runs_, dice_);
}

}  // namespace tribotrack::bench

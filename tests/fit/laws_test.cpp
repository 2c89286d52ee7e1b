// Laws of the fit: what a change of its data does to its result, whatever the data are. Each is applied to
// every kind of data and every loss.
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <ranges>

#include "apps/bench/comparison.h"
#include "fit/estimate.h"
#include "fit/free_slides.h"
#include "model/spinning_disc.h"
#include "model/trajectory.h"

// Simulated campaigns that are fitted point by point.

namespace tribotrack::test {

/// The runs of bench::simulated_campaign() point by point: `points` of each, evenly spaced over the cycles,
/// with 1e-6 m of noise per axis.
inline fit::Problem simulated_tracks(const bench::FitTruth& truth, unsigned seed, std::size_t points,
                                     double cycles) {
  constexpr double kSigma = 1e-6;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  fit::Problem problem = bench::simulated_campaign(truth, seed, cycles);
  for (const fit::SummaryRun& summary : problem.summary_runs) {
    fit::TrajectoryRun run;
    run.name = summary.name;
    run.scenario = summary.scenario;
    run.track.platform_frame = true;
    const model::Trajectory trajectory = model::integrate(run.scenario);
    for (std::size_t k = 0; k < points; ++k) {
      const double time = trajectory.end_time() * static_cast<double>(k) / static_cast<double>(points - 1);
      run.track.time.push_back(time);
      run.track.position.push_back(trajectory.at(time).position +
                                   Eigen::Vector2d(noise(random), noise(random)));
      run.track.covariance.push_back(kSigma * kSigma * Eigen::Matrix2d::Identity());
    }
    problem.trajectory_runs.push_back(run);
  }
  problem.summary_runs.clear();
  return problem;
}

}  // namespace tribotrack::test

namespace tribotrack::fit {
namespace {

constexpr double kPi = std::numbers::pi;
/// A descent ends within 1e-5 sd of its minimum (minimise.h), two of them within twice that; the curvature
/// there is another by as little, of a weighted loss by a few times more.
constexpr double kSameEstimate = 1e-4, kSameSd = 1e-4;
/// Of a minimum: twice the decrement of Newton at which a descent stops, and rounding of the model to 1e-9. A
/// Weighted losses stop where no weight moves by more than 1e-6.
constexpr double kSameChi2 = 1e-7, kSameWeightedChi2 = 1e-6;

/// One kind of data under one loss.
struct Method {
  const char* name;
  Problem (*problem)();
  Loss loss = Loss::squares;
  bool scatter = false;  ///< errors beyond the data's own are estimated
  friend void PrintTo(const Method& method, std::ostream* out) { *out << method.name; }
};

/// 14 displacements over 5 cycles, with noise.
Problem displacements() {
  return bench::simulated_campaign({0.1, 0.0125, 0.15}, 17, 5);
}

/// The same motion where chi^2 finds the stated sds three times too small.
Problem scattered_displacements() {
  Problem problem = displacements();
  for (SummaryRun& run : problem.summary_runs) run.measured.covariance /= 9;
  return problem;
}

/// 14 tracks of 60 points over 2 cycles.
Problem tracks() {
  return test::simulated_tracks({0.1, 0.0125, 0.15}, 17, 60, 2);
}

/// The same as a camera sees them that does not move with the platform.
Problem tracks_in_the_camera() {
  Problem problem = tracks();
  for (TrajectoryRun& run : problem.trajectory_runs) {
    const model::Scenario& s = run.scenario;
    for (std::size_t k = 0; k < run.track.time.size(); ++k)
      run.track.position[k] +=
          s.drive.displacement(s.start_phase + s.drive.angular_frequency * run.track.time[k]);
    run.track.platform_frame = false;
  }
  return problem;
}

/// Displacements of half of the runs, tracks of the others.
Problem mixed() {
  Problem problem = displacements();
  problem.summary_runs.resize(7);
  const Problem points = tracks();
  problem.trajectory_runs.assign(points.trajectory_runs.begin() + 7, points.trajectory_runs.end());
  return problem;
}

/// Three slides over a platform at rest, of discs that do not turn.
Problem slides() {
  std::mt19937 random(5);
  Problem problem;
  problem.free = {FitParameter::mu1};
  const test::UnitSlide straight(0);
  for (int k = 0; k < 3; ++k) {
    test::SlideLook look;
    look.angle = 0.4 + k;
    problem.trajectory_runs.push_back(test::slide_track(straight, 0, look, random, false));
    problem.trajectory_runs.back().name += std::to_string(k);
  }
  return problem;
}

FitOptions options_of(const Method& method) {
  return {.multi_starts = 1,
          .profiles = false,
          .next_experiment = false,
          .estimate_scatter = method.scatter,
          .loss = method.loss};
}

FitResult fitted(const Method& method, const Problem& problem) {
  FitResult result = estimate(problem, options_of(method));
  EXPECT_TRUE(result.converged);
  return result;
}

void for_each_scenario(Problem& problem, const std::function<void(model::Scenario&)>& change) {
  for (SummaryRun& run : problem.summary_runs) change(run.scenario);
  for (TrajectoryRun& run : problem.trajectory_runs) change(run.scenario);
}

/// Every measured length through a linear map of the plane.
void map_lengths(Problem& problem, const Eigen::Matrix2d& map) {
  for (SummaryRun& run : problem.summary_runs) {
    Displacement& d = run.measured;
    d.vector = (map * d.vector).eval();
    d.covariance = (map * d.covariance * map.transpose()).eval();
    derive_alpha_and_v(d);
  }
  const double size = std::sqrt(std::abs(map.determinant()));
  for (TrajectoryRun& run : problem.trajectory_runs) {
    for (Eigen::Vector2d& p : run.track.position) p = (map * p).eval();
    for (Eigen::Matrix2d& c : run.track.covariance) c = (map * c * map.transpose()).eval();
    run.track.radius *= size;
  }
}

double same_chi2(const FitResult& result) {
  return result.loss == Loss::squares ? kSameChi2 : kSameWeightedChi2;
}

/// The same values and sds.
void expect_same_values(const FitResult& one, const FitResult& other,
                        FitParameter parameter = FitParameter::mu1, double factor = 1, double shift = 0) {
  ASSERT_EQ(one.parameters.size(), other.parameters.size());
  for (std::size_t k = 0; k < one.parameters.size(); ++k) {
    const ParameterEstimate &a = one.parameters[k], &b = other.parameters[k];
    const bool this_one = a.parameter == parameter;
    const double grown = this_one ? factor : 1, moved = this_one ? shift : 0;
    EXPECT_NEAR((b.estimate - moved) / grown, a.estimate, kSameEstimate * a.sd) << to_string(a.parameter);
    EXPECT_NEAR(b.sd / grown, a.sd, kSameSd * a.sd) << to_string(a.parameter);
  }
}

/// The same values, sds and chi^2, but for `parameter`, whose value moves by `shift` and grows by `factor`.
void expect_same(const FitResult& one, const FitResult& other, FitParameter parameter = FitParameter::mu1,
                 double factor = 1, double shift = 0) {
  expect_same_values(one, other, parameter, factor, shift);
  EXPECT_NEAR(other.chi2, one.chi2, same_chi2(one) * one.chi2);
}

/// sd by which weighted displacements are uncertain, per 1/sqrt(n): Huber, "Robust Statistics" (1981),
/// section 7.6, K sqrt(n/(n - p)) with K = 1 + p/n var(psi')/mean(psi')^2, psi' of the loss in the plane.
double finite_sample_factor(const FitResult& result, double repeats) {
  double mean = 0, square = 0;
  const auto runs = static_cast<double>(result.runs.size());
  for (const RunResult& run : result.runs) {
    const double s = std::hypot(run.residuals[0].standardised, run.residuals[1].standardised);
    const double slope = s < 2 ? 1 : 1 / s;
    mean += slope / runs;
    square += slope * slope / runs;
  }
  const double n = 2 * runs * repeats, p = static_cast<double>(result.parameters.size());
  return (1 + p / n * (square - mean * mean) / (mean * mean)) * std::sqrt(n / (n - p));
}

class FitLaws : public testing::TestWithParam<Method> {
 protected:
  const Method& method = GetParam();
  const Problem problem = method.problem();
  const FitResult ordinary = fitted(method, problem);
  bool driven() const { return problem.free.size() > 1; }
};

TEST_P(FitLaws, TheOrderOfRunsIsIrrelevant) {
  Problem reversed = problem;
  std::ranges::reverse(reversed.summary_runs);
  std::ranges::reverse(reversed.trajectory_runs);
  expect_same(ordinary, fitted(method, reversed));
}

TEST_P(FitLaws, TheOrderOfParametersIsIrrelevant) {
  Problem reversed = problem;
  std::ranges::reverse(reversed.free);
  FitResult other = fitted(method, reversed);
  std::ranges::reverse(other.parameters);
  expect_same(ordinary, other);
}

TEST_P(FitLaws, EveryRunTwiceLeavesTheValuesAndDividesTheirStandardDeviationsByRootTwo) {
  if (method.scatter) GTEST_SKIP() << "repeated runs tell of the scatter by themselves";
  Problem twice = problem;
  for (SummaryRun run : problem.summary_runs) {
    run.name += " again";
    twice.summary_runs.push_back(run);
  }
  for (TrajectoryRun run : problem.trajectory_runs) {
    run.name += " again";
    twice.trajectory_runs.push_back(run);
  }
  const FitResult two = fitted(method, twice);
  const double fewness = method.loss == Loss::squares
                             ? 1
                             : finite_sample_factor(ordinary, 1) / finite_sample_factor(ordinary, 2);
  for (std::size_t k = 0; k < ordinary.parameters.size(); ++k) {
    const ParameterEstimate &a = ordinary.parameters[k], &b = two.parameters[k];
    EXPECT_NEAR(b.estimate, a.estimate, kSameEstimate * a.sd) << to_string(a.parameter);
    EXPECT_NEAR(b.sd * std::sqrt(2.0) * fewness, a.sd, kSameSd * a.sd) << to_string(a.parameter);
  }
  EXPECT_NEAR(two.chi2, 2 * ordinary.chi2, 2 * same_chi2(ordinary) * ordinary.chi2);
}

// Lengths, amplitude and gravity a hundred times as large: the same motion in centimetres, with numbers that
// the fit takes for metres. mu and lag have no unit.
TEST_P(FitLaws, AnotherUnitOfLengthChangesNeitherFrictionNorItsStandardDeviation) {
  Problem centimetres = problem;
  for_each_scenario(centimetres, [](model::Scenario& s) {
    s.drive.amplitude *= 100;
    s.drive.amplitude_y *= 100;
    s.drive.gravity *= 100;
  });
  map_lengths(centimetres, 100 * Eigen::Matrix2d::Identity());
  const FitResult other = fitted(method, centimetres);
  expect_same_values(ordinary, other);
  // No point of a track is taken for better than 1e-9 m, which is 1e-3 of the sds here and nothing there.
  const double floor = problem.trajectory_runs.empty() ? 0 : 1.01e-6;
  EXPECT_NEAR(other.chi2, ordinary.chi2, (floor + same_chi2(ordinary)) * ordinary.chi2);
}

// Time in units of a tenth of a second.
TEST_P(FitLaws, AnotherUnitOfTimeChangesNeitherFrictionNorItsStandardDeviation) {
  constexpr double kUnits = 10;  // in a second
  Problem tenths = problem;
  for_each_scenario(tenths, [](model::Scenario& s) {
    s.drive.angular_frequency /= kUnits;
    s.drive.gravity /= kUnits * kUnits;
    s.duration *= kUnits;
  });
  for (SummaryRun& run : tenths.summary_runs) {
    run.measured.duration *= kUnits;
    derive_alpha_and_v(run.measured);
  }
  for (TrajectoryRun& run : tenths.trajectory_runs)
    for (double& t : run.track.time) t *= kUnits;
  expect_same(ordinary, fitted(method, tenths));
}

// Friction acts as mu g: on another planet the same motion is seen with another mu.
TEST_P(FitLaws, FrictionIsKnownAsItsProductWithGravity) {
  constexpr double kFactor = 1.6;
  Problem elsewhere = problem;
  for_each_scenario(elsewhere, [](model::Scenario& s) { s.drive.gravity /= kFactor; });
  const FitResult there = fitted(method, elsewhere);
  for (std::size_t k = 0; k < ordinary.parameters.size(); ++k) {
    const ParameterEstimate &a = ordinary.parameters[k], &b = there.parameters[k];
    const double grown = a.parameter == FitParameter::lag ? 1 : kFactor;
    EXPECT_NEAR(b.estimate / grown, a.estimate, kSameEstimate * a.sd) << to_string(a.parameter);
    EXPECT_NEAR(b.sd / grown, a.sd, kSameSd * a.sd) << to_string(a.parameter);
  }
  EXPECT_NEAR(there.chi2, ordinary.chi2, same_chi2(ordinary) * ordinary.chi2);
}

// The camera upside down: y and with it the sense of the platform's circling change sign.
TEST_P(FitLaws, AMirroredCampaignHasTheSameFriction) {
  Problem mirrored = problem;
  for_each_scenario(mirrored, [](model::Scenario& s) { s.drive.phase_shift += kPi; });
  map_lengths(mirrored, Eigen::Vector2d(1, -1).asDiagonal());
  expect_same(ordinary, fitted(method, mirrored));
}

// All phases counted from a quarter of a radian later, and the camera turned with them: circular drive knows
// no direction.
TEST_P(FitLaws, AllPhasesAndTheCameraTurnedTogetherChangeNothing) {
  constexpr double kTurn = 0.25;
  Problem turned = problem;
  for_each_scenario(turned, [](model::Scenario& s) {
    s.friction.phase += kTurn;
    s.start_phase += kTurn;
  });
  // The platform circles clockwise.
  map_lengths(turned, Eigen::Rotation2Dd(-kTurn).toRotationMatrix());
  expect_same(ordinary, fitted(method, turned));
}

// Only phi + lag is seen.
TEST_P(FitLaws, CommandedPhasesThatAreLaterByAnAngleGiveALagThatIsLessByIt) {
  if (!driven()) GTEST_SKIP() << "free slides have no pulses";
  constexpr double kLater = 0.07;
  Problem later = problem;
  for_each_scenario(later, [](model::Scenario& s) { s.friction.phase += kLater; });
  expect_same(ordinary, fitted(method, later), FitParameter::lag, 1, -kLater);
}

// Where all runs have one w, a delay is the lag in other words.
TEST_P(FitLaws, ADelayIsTheLagOverTheFrequency) {
  if (!driven()) GTEST_SKIP() << "free slides have no pulses";
  const double w = (problem.summary_runs.empty() ? problem.trajectory_runs.front().scenario
                                                 : problem.summary_runs.front().scenario)
                       .drive.angular_frequency;
  Problem delayed = problem;
  std::ranges::replace(delayed.free, FitParameter::lag, FitParameter::delay);
  if (const auto guess = delayed.start.extract(FitParameter::lag))
    delayed.start[FitParameter::delay] = guess.mapped() / w;
  expect_same(ordinary, fitted(method, delayed), FitParameter::lag, 1 / w);
}

// A clock that was started earlier.
TEST_P(FitLaws, WhenTheRecordingBeganIsIrrelevant) {
  Problem later = problem;
  for (TrajectoryRun& run : later.trajectory_runs)
    for (double& t : run.track.time) t += 3.25;
  expect_same(ordinary, fitted(method, later));
}

INSTANTIATE_TEST_SUITE_P(
    EveryMethod, FitLaws,
    testing::Values(Method{"displacements", displacements},
                    Method{"displacements_huber", displacements, Loss::huber},
                    Method{"displacements_scattered", scattered_displacements, Loss::squares, true},
                    Method{"tracks", tracks}, Method{"tracks_in_the_camera", tracks_in_the_camera},
                    Method{"mixed", mixed}, Method{"slides", slides}),
    [](const testing::TestParamInfo<Method>& method) { return std::string(method.param.name); });

}  // namespace
}  // namespace tribotrack::fit

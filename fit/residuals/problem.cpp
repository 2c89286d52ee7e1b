#include "fit/problem.h"

#include <numbers>
#include <set>

#include "fit/tools/dense.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/parameters.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {
namespace {

void need(const Problem& problem, FitParameter parameter) {
  if (problem.fits(parameter) || problem.fixed.count(parameter)) return;
  throw DataError(std::string("No value for ") + to_string(parameter) +
                  ": fit it ([fit] parameters) or give it ([fit.fixed]).");
}

void check_value(FitParameter parameter, double value, const char* where) {
  const internal::Sort sort = internal::facts(parameter).sort;
  const bool positive = sort == internal::Sort::positive, not_negative = sort == internal::Sort::not_negative;
  if (!std::isfinite(value) || (positive && !(value > 0)) || (not_negative && value < 0))
    throw DataError(std::string(where) + " " + to_string(parameter) + " = " + std::to_string(value) +
                    " is out of range" +
                    (positive       ? ": it must be positive."
                     : not_negative ? ": it must not be negative."
                                    : "."));
}

void check_run(const SummaryRun& run) {
  run.scenario.validate();
  if (!run.measured.vector.allFinite() || !run.measured.covariance.allFinite())
    throw DataError("Run '" + run.name + "': the displacement holds a value that is not a number.");
  if (!internal::Factor2(run.measured.covariance).positive())
    throw DataError(
        "Run '" + run.name +
        "': the displacement's covariance is not positive definite: give alpha_sd_rad and v_sd_mm_s "
        "above 0.");
}

/// Beyond it tan(slope) > 1.
constexpr double kSteepest = std::numbers::pi / 4;

void check_run(const TrajectoryRun& run) {
  run.scenario.validate();
  if (!(run.start_phase_sd >= 0) || !std::isfinite(run.start_phase_sd))
    throw DataError("Run '" + run.name + "': the sd of the platform's phase must not be negative.");
  const auto errors = static_cast<Eigen::Index>(run.own.parameters.size());
  if (run.own.covariance.rows() != errors || run.own.covariance.cols() != errors ||
      (errors > 0 && !internal::Factor(run.own.covariance).positive()))
    throw DataError("Run '" + run.name + "': the covariance of its own errors is not positive definite.");
  if (run.spin && (!run.free_slide || !(run.track.radius > 0) || !std::isfinite(run.spin->rate) ||
                   !std::isfinite(run.spin->bearing) || !internal::Factor2(run.spin->covariance).positive()))
    throw DataError("Run '" + run.name +
                    "': a spin belongs to a free slide, with its covariance and the part's radius.");
  if (run.slope != 0 && !run.free_slide)
    throw DataError("Run '" + run.name + "': a slope belongs to a free slide.");
  if (!(std::abs(run.slope) <= kSteepest))
    throw DataError("Run '" + run.name + "': its slope must lie within pi/4.");
  const auto& track = run.track;
  if (track.angle.size() != track.angle_sigma.size() ||
      (!track.angle.empty() && track.angle.size() != track.time.size()))
    throw DataError("Run '" + run.name + "': the track has angles for some of its rows only.");
  const std::size_t n = track.time.size();
  if (n < 8 || track.position.size() != n || track.covariance.size() != n)
    throw DataError("Run '" + run.name + "': " + std::to_string(n) +
                    " tracked points; a fit to the trajectory needs at least 8.");
  for (const SlowError& slow : track.slow)
    if (!(slow.sd >= 0) || !(slow.time > 0) || !std::isfinite(slow.sd))
      throw DataError("Run '" + run.name + "': a slow error of the track has no sd or no correlation time.");
  for (std::size_t i = 0; i < n; ++i)
    if (!std::isfinite(track.time[i]) || !track.position[i].allFinite() || !track.covariance[i].allFinite() ||
        (i > 0 && !(track.time[i] > track.time[i - 1])))
      throw DataError("Run '" + run.name + "': row " + std::to_string(i + 1) +
                      " of the track holds a value that is not a number, or a time that does not increase.");
}

}  // namespace

const char* to_string(FitParameter parameter) {
  return internal::facts(parameter).name;
}

bool Problem::has_pulses() const {
  return std::ranges::any_of(summary_runs,
                             [](const SummaryRun& r) { return r.scenario.friction.pulse_width > 0; }) ||
         std::ranges::any_of(trajectory_runs, [](const TrajectoryRun& r) {
           return !r.free_slide && r.scenario.friction.pulse_width > 0;
         });
}

bool Problem::has_driven_tracks() const {
  return std::ranges::any_of(trajectory_runs, [](const TrajectoryRun& run) { return !run.free_slide; });
}

bool Problem::counts_run_scatter() const {
  const auto differs = [](const auto& run) { return run.own.sd(model::Parameter::mu1) > 0; };
  return std::ranges::any_of(summary_runs, differs) || std::ranges::any_of(trajectory_runs, differs);
}

bool Problem::sets_free(FitParameter quantity) const {
  return std::ranges::any_of(
      conditions, [&](const Condition& c) { return c.quantity == quantity && c.from == kSetFree; });
}

void Problem::validate() const {
  if (free.empty()) throw DataError("Nothing to fit: [fit] parameters is empty.");
  if (std::set<FitParameter>(free.begin(), free.end()).size() != free.size())
    throw DataError("A parameter stands twice in [fit] parameters.");
  if (summary_runs.empty() && trajectory_runs.empty()) throw DataError("No run to fit to.");
  for (const auto parameter : free)
    if (fixed.count(parameter))
      throw DataError(std::string(to_string(parameter)) + " is both fitted and fixed: take it out of one.");
  for (const auto& [parameter, value] : fixed) check_value(parameter, value, "fit.fixed");
  for (const auto& [parameter, value] : start) check_value(parameter, value, "fit.guess");
  for (const auto& [parameter, known] : prior) {
    check_value(parameter, known.mean, "fit.prior");
    if (!(known.sd > 0) || !std::isfinite(known.sd))
      throw DataError(std::string("fit.prior ") + to_string(parameter) + ": sd must be positive.");
  }
  for (const Condition& condition : conditions)
    if (!(condition.sd >= 0) || !std::isfinite(condition.sd))
      throw DataError(std::string("The sd of ") + to_string(condition.quantity) + " must not be negative.");
  if (!(between_slides >= 0) || !std::isfinite(between_slides))
    throw DataError("The sd of mu1 between slides must not be negative.");

  for (const auto& run : summary_runs) check_run(run);
  for (const auto& run : trajectory_runs) check_run(run);
  need(*this, FitParameter::mu1);
  if (has_pulses()) need(*this, FitParameter::mu2);
}

namespace {

/// The largest acceleration of the platform within a turn: the long half-axis of its ellipse times w^2.
double hardest(const model::Drive& drive) {
  const double x = drive.amplitude * drive.amplitude, y = drive.amplitude_y * drive.amplitude_y;
  const double mixed = drive.amplitude * drive.amplitude_y * std::cos(drive.phase_shift);
  return std::sqrt(0.5 * (x + y) + std::hypot(0.5 * (x - y), mixed)) * drive.angular_frequency *
         drive.angular_frequency;
}

/// chi^2 of two degrees of freedom that chance exceeds with probability kSurprise.
const double kMoved = -2 * std::log(internal::kSurprise);

bool moved(const Eigen::Vector2d& displacement, const Eigen::Matrix2d& covariance) {
  return displacement.dot(internal::Factor2(covariance).solved(displacement)) > kMoved;
}

}  // namespace

std::optional<std::string> Problem::stuck_throughout() const {
  double held = 0;  // mu that held the part in the hardest run
  const auto take = [&](const model::Scenario& scenario) {
    held = std::max(held, hardest(scenario.drive) / scenario.drive.gravity);
  };
  for (const auto& run : summary_runs) {
    if (moved(run.measured.vector, run.measured.covariance)) return std::nullopt;
    take(run.scenario);
  }
  for (const auto& run : trajectory_runs) {
    if (run.free_slide || moved(run.track.position.back() - run.track.position.front(),
                                run.track.covariance.back() + run.track.covariance.front()))
      return std::nullopt;
    take(run.scenario);
  }
  if (!(held > 0)) return std::nullopt;
  return "No run moved beyond its error: the part sticks throughout. The data only show that friction, "
         "reduced or not, held it: mu1 and mu2 above A w^2/g = " +
         internal::number(held) + ". Drive harder (A w^2 above mu1 g), or check that the actuator works.";
}

double Problem::typical_displacement() const {
  std::vector<double> lengths;
  for (const SummaryRun& run : summary_runs) lengths.push_back(run.measured.vector.norm());
  for (const TrajectoryRun& run : trajectory_runs)
    lengths.push_back((run.track.position.back() - run.track.position.front()).norm());
  return internal::upper_median(lengths);
}

}  // namespace tribotrack::fit

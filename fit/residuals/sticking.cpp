#include "fit/residuals/sticking.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/dense.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

/// The largest acceleration of the platform within a turn: the long half-axis of its ellipse times w^2.
double hardest(const model::Drive& drive) {
  const double x = drive.amplitude * drive.amplitude, y = drive.amplitude_y * drive.amplitude_y;
  const double mixed = drive.amplitude * drive.amplitude_y * std::cos(drive.phase_shift);
  return std::sqrt(0.5 * (x + y) + std::hypot(0.5 * (x - y), mixed)) * drive.angular_frequency *
         drive.angular_frequency;
}

/// chi^2 of two degrees of freedom that chance exceeds with probability kSurprise.
const double kMoved = -2 * std::log(kSurprise);

bool moved(const Eigen::Vector2d& displacement, const Eigen::Matrix2d& covariance) {
  return displacement.dot(Factor2(covariance).solved(displacement)) > kMoved;
}

}  // namespace

std::optional<std::string> stuck_throughout(const Problem& problem) {
  double held = 0;  // mu that held the part in the hardest run
  const auto take = [&](const model::Scenario& scenario) {
    held = std::max(held, hardest(scenario.drive) / scenario.drive.gravity);
  };
  for (const auto& run : problem.summary_runs) {
    if (moved(run.measured.vector, run.measured.covariance)) return std::nullopt;
    take(run.scenario);
  }
  for (const auto& run : problem.trajectory_runs) {
    if (run.free_slide || moved(run.track.position.back() - run.track.position.front(),
                                run.track.covariance.back() + run.track.covariance.front()))
      return std::nullopt;
    take(run.scenario);
  }
  if (!(held > 0)) return std::nullopt;
  return "No run moved beyond its error: the part sticks throughout. The data only show that friction, "
         "reduced or not, held it: mu1 and mu2 above A w^2/g = " +
         number(held) + ". Drive harder (A w^2 above mu1 g), or check that the actuator works.";
}

}  // namespace tribotrack::fit::internal

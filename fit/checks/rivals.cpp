#include "fit/checks/rivals.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "fit/tools/dense.h"

#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

using Kind = model::RivalLaw::Kind;

/// Residuals in steps: unknowns' z, then the strength in its unit.
class RivalProblem {
 public:
  RivalProblem(const Residuals& residuals, Kind kind, int threads)
      : residuals_(residuals),
        unknowns_(residuals.unknowns()),
        kind_(kind),
        threads_(threads),
        unit_(strength_unit(kind, unknowns_.reference_frequency())) {}

  Eigen::Index size() const { return unknowns_.size() + (kind_ == Kind::coulomb ? 0 : 1); }
  /// A rise time cannot be negative: its step is squared.
  double strength(const Eigen::VectorXd& step) const {
    if (kind_ == Kind::coulomb) return 0;
    const double s = step(unknowns_.size());
    return unit_ * (kind_ == Kind::rise_time ? s * s : s);
  }
  double strength_slope(const Eigen::VectorXd& step) const {
    return kind_ == Kind::rise_time ? 2 * unit_ * step(unknowns_.size()) : unit_;
  }

  std::optional<Eigen::VectorXd> at(const Eigen::VectorXd& step) const {
    const Problem& problem = unknowns_.problem();
    Eigen::VectorXd values = unknowns_.values(step.head(unknowns_.size()));
    // A rise acts like half of it as a delay: the lag of its middle is what the data know.
    if (const auto lag = unknowns_.find(FitParameter::lag); lag && kind_ == Kind::rise_time)
      values(*lag) -= 0.5 * unknowns_.reference_frequency() * strength(step);
    const Eigen::Index data = residuals_.trajectory_row(problem.trajectory_runs.size());
    Eigen::VectorXd r = Eigen::VectorXd::Zero(data + unknowns_.common() +
                                              static_cast<Eigen::Index>(problem.trajectory_runs.size()));
    try {
      for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
        const SummaryRun& run = problem.summary_runs[i];
        const auto applied = unknowns_.apply_summary(values, run, false);
        const Eigen::Vector2d end = model::rival_displacement(applied.scenario, {kind_, strength(step)}) *
                                    (applied.stretch / applied.scale);
        r.segment<2>(2 * static_cast<Eigen::Index>(i)) =
            Factor2(residuals_.covariance(i)).whitened(run.measured.vector - end);
      }
      for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
        r.segment(residuals_.trajectory_row(i), 2 * static_cast<Eigen::Index>(residuals_.point_count(i))) =
            trajectory(values, i, {kind_, strength(step)});
      residuals_.whiten_common(r);
    } catch (const model::InvalidParameter&) {
      return std::nullopt;
    }
    Eigen::Index row = data;
    for (Eigen::Index i = 0; i < unknowns_.common(); ++i)
      if (const auto prior = unknowns_.prior(i)) r(row++) = (values(i) - prior->mean) / prior->sd;
    for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
      if (const Eigen::Index k = unknowns_.deviation_index(i); k >= 0)
        r(row++) = values(k) / problem.between_slides;
    return r;
  }

  std::optional<Eigen::MatrixXd> jacobian(const Eigen::VectorXd& step) const {
    constexpr double kStep = 1e-3;
    std::vector<std::optional<Eigen::VectorXd>> columns(static_cast<std::size_t>(size()));
    parallel_for(columns.size(), threads_, [&](std::size_t k) {
      const Eigen::VectorXd h = kStep * Eigen::VectorXd::Unit(size(), static_cast<Eigen::Index>(k));
      const auto up = at(step + h), down = at(step - h);
      if (up && down) columns[k] = (*up - *down) / (2 * kStep);
    });
    Eigen::MatrixXd jacobian;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (!columns[k]) return std::nullopt;
      jacobian.conservativeResize(columns[k]->size(), size());
      jacobian.col(static_cast<Eigen::Index>(k)) = *columns[k];
    }
    return jacobian;
  }

 private:
  Eigen::VectorXd trajectory(const Eigen::VectorXd& values, std::size_t index,
                             const model::RivalLaw& law) const {
    const TrajectoryRun& run = unknowns_.problem().trajectory_runs[index];
    const AppliedScenario applied = run.free_slide ? unknowns_.apply_free_slide(values, index, false)
                                                   : unknowns_.apply_trajectory(values, index, false);
    const std::size_t n = residuals_.point_count(index), first = run.track.time.size() - n;
    std::vector<double> times;
    for (std::size_t k = first; k < first + n; ++k)
      times.push_back(run.track.time[k] - run.track.time[first]);
    model::Scenario scenario = applied.scenario;
    scenario.duration = times.back();
    Eigen::Matrix2Xd positions = model::rival_positions(scenario, law, times);
    if (!run.free_slide && !run.track.platform_frame)
      for (std::size_t k = 0; k < n; ++k)
        positions.col(static_cast<Eigen::Index>(k)) +=
            scenario.drive.displacement(scenario.start_phase + scenario.drive.angular_frequency * times[k]);
    Eigen::VectorXd r(2 * static_cast<Eigen::Index>(n));
    residuals_.whiten(index, positions / applied.scale, r);
    return r;
  }

  const Residuals& residuals_;
  const Unknowns& unknowns_;
  Kind kind_;
  int threads_;
  double unit_;
};

}  // namespace

double strength_unit(Kind law, double angular_frequency) {
  switch (law) {
    case Kind::viscous:
      return 0.1 * angular_frequency;
    case Kind::rise_time:
      return 0.1 / angular_frequency;
    default:
      return 1;
  }
}

RivalFit fit_rival(const Residuals& residuals, const Minimum& best, Kind law, int threads) {
  const RivalProblem rival(residuals, law, threads);
  Eigen::VectorXd step(rival.size());
  step.head(best.z.size()) = best.z;
  if (law != Kind::coulomb) step(best.z.size()) = law == Kind::rise_time ? 1 : 0;
  RivalFit fit;
  auto r = rival.at(step);
  if (!r) return fit;
  double damping = 1e-4;
  std::optional<Eigen::MatrixXd> j;
  for (int iteration = 0; iteration < 30 && !fit.converged; ++iteration) {
    j = rival.jacobian(step);
    if (!j) return fit;
    const Eigen::MatrixXd normal = j->transpose() * *j;
    const Eigen::VectorXd gradient = j->transpose() * *r;
    for (int attempt = 0; attempt < 8; ++attempt) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal().cwiseMax(1e-12 * normal.diagonal().maxCoeff());
      const Eigen::VectorXd change = -solve_symmetric(damped, gradient);
      const double promised = -(2 * gradient.dot(change) + change.dot(normal * change));
      if (promised < 1e-3) {  // a thirtieth of a standard deviation
        fit.converged = true;
        break;
      }
      const auto trial = rival.at(step + change);
      if (trial && trial->squaredNorm() < r->squaredNorm()) {
        step += change;
        r = trial;
        damping = std::max(0.1 * damping, 1e-9);
        break;
      }
      damping = std::max(10 * damping, 1e-3);
    }
  }
  fit.chi2 = r->squaredNorm();
  fit.z = step.head(best.z.size());
  fit.strength = rival.strength(step);
  if (fit.chi2 > best.chi2) {  // never worse than the law it contains
    fit.chi2 = best.chi2;
    fit.z = best.z;
    fit.strength = 0;
  }
  if (law != Kind::coulomb) {
    const Eigen::MatrixXd covariance = inverse_symmetric(j->transpose() * *j);
    fit.sd = std::abs(rival.strength_slope(step)) *
             std::sqrt(std::max(0.0, covariance(rival.size() - 1, rival.size() - 1)));
  }
  return fit;
}

}  // namespace tribotrack::fit::internal

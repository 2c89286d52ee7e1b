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
    Eigen::VectorXd values = unknowns_.values(step.head(unknowns_.size()));
    // A rise acts like half of it as a delay: the lag of its middle is what the data know.
    if (const auto lag = unknowns_.find(FitParameter::lag); lag && kind_ == Kind::rise_time)
      values(*lag) -= 0.5 * unknowns_.reference_frequency() * strength(step);
    Residuals under_law = residuals_;
    under_law.set_law({kind_, strength(step)});
    const auto rows = under_law.at(values, false);
    return rows ? std::optional(rows->residuals()) : std::nullopt;
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

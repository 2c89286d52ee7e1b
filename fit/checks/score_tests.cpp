#include "fit/checks/score_tests.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "fit/checks/run_scatter.h"
#include "fit/checks/runs.h"
#include "fit/minimum/multi_start.h"
#include "fit/tools/dense.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {
namespace {

double sliding_speed(const Unknowns& unknowns, const Eigen::VectorXd& values, std::size_t slide) {
  return values.segment<2>(unknowns.find(Nuisance::velocity, slide)->first).norm();
}

}  // namespace

const std::vector<Candidate>& candidates() {
  using enum FitParameter;
  static const std::vector<Candidate> all = {
      {"tilt", "a tilt of the platform", "rad", 1, {tilt_x, tilt_y}},
      {"amplitude", "another amplitude", "%", 0, {amplitude}},
      {"amplitude_ratio", "unequal amplitudes along x and y", "%", 100, {amplitude_ratio}},
      {"phase_shift", "another phase shift between x and y", "rad", 1, {phase_shift}},
      {"clock", "another frequency of the platform", "%", 0, {angular_frequency}},
      {"scale", "another scale", "%", 100, {scale}},
      {"start_phase", "another phase of the platform at the start", "rad", 1, {start_phase}},
      {kStribeck, "friction that falls with speed (Stribeck)", "%", 100, {stribeck}, true},
      {"viscous", "friction that rises with speed (viscous)", "1/s", 1, {viscous}, true},
      {"mu2_speed", "a reduced friction that rises with speed", "%", 100, {mu2_speed}, true},
      {"mu2_width", "a reduced friction that changes with the width of the gate", "%/rad", 100, {mu2_width}},
      {"gate_edges", "gate edges that take their time", "rad", 1, {gate_edges}, true},
      {"static_friction", "a higher friction at rest", "%", 100, {static_friction}, true},
      {"wear", "friction that changes in the course of the campaign", "%", 100, {wear}},
      {kUnseenSpin, "a spin that was not seen", "times the sliding speed at the edge", 1, {}}};
  return all;
}

Problem with_free(Problem problem, const std::vector<FitParameter>& quantities) {
  constexpr double kUnknown = 1e3;  ///< an sd that says nothing: of a relative value, or rad
  for (const FitParameter quantity : quantities) {
    std::erase_if(problem.conditions, [&](const Condition& c) { return c.quantity == quantity; });
    problem.prior.erase(quantity);
    const double size = std::abs(Unknowns(problem).as_given(quantity));
    const bool sized = quantity == FitParameter::amplitude || quantity == FitParameter::angular_frequency;
    problem.conditions.push_back({quantity, kUnknown * (sized ? size : 1), kSetFree});
    if (quantity == FitParameter::stribeck &&
        std::ranges::count(problem.conditions, FitParameter::stribeck_speed, &Condition::quantity) == 0)
      problem.conditions.push_back({FitParameter::stribeck_speed, kStribeckSpeed, kSetFree});
  }
  return problem;
}

std::optional<Problem> with_unseen_spin(Problem problem, const Unknowns& unknowns,
                                        const Eigen::VectorXd& values) {
  constexpr double kWholeFace = 0.05;  ///< sd of ln of the bearing radius
  const auto unseen = [](const TrajectoryRun& run) { return run.free_slide && !run.spin && run.slope == 0; };
  constexpr std::size_t kMany = 16;
  if (!problem.summary_runs.empty() || problem.trajectory_runs.size() > kMany ||
      !std::ranges::all_of(problem.trajectory_runs, unseen))
    return std::nullopt;
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    TrajectoryRun& slide = problem.trajectory_runs[i];
    if (!(slide.track.radius > 0)) slide.track.radius = 1;  // only the edge's speed counts
    const double rate = 0.5 * sliding_speed(unknowns, values, i) / slide.track.radius;
    slide.spin = DiscSpin{rate, 0, Eigen::Vector2d(rate * rate, kWholeFace * kWholeFace).asDiagonal()};
  }
  return problem;
}

ScoreTests::ScoreTests(const Residuals& residuals, const Minimum& best, int threads)
    : residuals_(residuals),
      unknowns_(residuals.unknowns()),
      problem_(unknowns_.problem()),
      best_(best),
      threads_(threads),
      values_(unknowns_.values(best.z)),
      wide_problem_(with_all_free()),
      wide_(wide_problem_) {
  Residuals rows = of(wide_, values_);
  rows.linearise(wide_.values_of(unknowns_, values_));
  if (const auto at = rows.at(wide_.values_of(unknowns_, values_))) at_ = at->eliminated();
  if (at_.empty()) return;
  normal_ = at_.normal();
  gradient_ = at_.gradient();
  for (Eigen::Index i = 0; i < unknowns_.common(); ++i)
    columns_.push_back(*wide_.find(unknowns_.parameter(i)));
  information_ = inverse_symmetric(normal_(columns_, columns_));
  step_ = information_ * gradient_(columns_);
}

/// Slides have no viscous part of their own here, which would leave nothing to the one of all.
Problem ScoreTests::with_all_free() const {
  std::vector<FitParameter> free;
  for (const Candidate& candidate : candidates())
    for (const FitParameter quantity : candidate.quantities)
      if (!unknowns_.find(quantity)) free.push_back(quantity);
  Problem problem = with_free(problem_, free);
  problem.between_viscous_slides = {};
  return problem;
}

Residuals ScoreTests::of(const Unknowns& unknowns, const Eigen::VectorXd& values) const {
  Residuals rows(unknowns, threads_);
  rows.set_tolerance(1e-8);
  rows.set_excess_variance(residuals_.excess_variance());
  rows.set_own_errors(unknowns.values_of(unknowns_, values));
  return rows;
}

ScoreTests::Products ScoreTests::products(Eigen::Index size) const {
  return {Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, unknowns_.common()),
          Eigen::VectorXd::Zero(size)};
}

std::optional<Explanation> ScoreTests::test(const Candidate& candidate) const {
  if (candidate.quantities.empty()) return std::nullopt;
  Products g = products(static_cast<Eigen::Index>(candidate.quantities.size()));
  for (std::size_t i = 0; i < candidate.quantities.size(); ++i) {
    const FitParameter quantity = candidate.quantities[i];
    const auto k = static_cast<Eigen::Index>(i);
    if (const auto known = unknowns_.find(quantity)) {
      if (*known < unknowns_.reported()) return std::nullopt;
      // Its prior's row, moved: by sizes that grow as what is known to an sd does.
      const Prior prior = *unknowns_.prior(*known);
      g.own(k, k) = 1;
      g.with_unknowns.row(k).setZero();
      g.with_unknowns(k, *known) = -1 / prior.sd;
      g.with_residuals(k) = -(values_(*known) - prior.mean) / prior.sd;
      continue;
    }
    const auto column = wide_.find(quantity);
    // Of slides alone a scale is friction's own.
    if (!column || (quantity == FitParameter::scale && !unknowns_.sliding_threshold())) return std::nullopt;
    // What moves nothing has the information of the prior alone that frees it.
    if (normal_(*column, *column) < 2 / std::pow(wide_.prior(*column)->sd, 2)) return std::nullopt;
    for (std::size_t j = 0; j < candidate.quantities.size(); ++j)
      if (const auto other = wide_.find(candidate.quantities[j]))
        g.own(k, static_cast<Eigen::Index>(j)) = normal_(*column, *other);
    g.with_unknowns.row(k) = normal_(*column, columns_);
    g.with_residuals(k) = gradient_(*column);
  }
  auto found = test(g);
  if (!found) return std::nullopt;
  found->name = candidate.name;
  found->unit = candidate.unit;
  if (candidate.never_negative && found->size < 0) found->chi2_fall = 0;
  tell_size(candidate, found->size, found->size_sd, *found);
  return found;
}

std::optional<Explanation> ScoreTests::test_run(std::size_t run) const {
  const RowGroup& rows = at_.groups.front();
  Products g = products(2);
  const auto row = 2 * static_cast<Eigen::Index>(run);
  g.own.setIdentity();
  g.with_unknowns = rows.shared.middleRows(row, 2)(Eigen::all, columns_);
  g.with_residuals = rows.residuals.segment(row, 2);
  auto found = test(g);
  if (!found) return std::nullopt;
  found->name = "bad_run";
  found->unit = "sd";
  found->run = problem_.summary_runs[run].name;
  found->size = std::sqrt(found->chi2_fall);
  found->size_sd = 1;
  return found;
}

std::optional<Explanation> ScoreTests::test_scatter() const {
  const auto scatter = run_scatter(of(wide_, values_), wide_.values_of(unknowns_, values_), at_);
  if (!scatter) return std::nullopt;
  Explanation found = scatter_of(100 * scatter->relative, 2 * problem_.summary_runs.size());
  found.chi2_fall = scatter->fall;
  found.p_after = residuals_.p_value(scatter->chi2, 1);
  found.parameters = estimates_under(unknowns_, values_, information_);
  return found;
}

Eigen::VectorXd ScoreTests::refit(const Problem& problem, const Candidate* candidate, bool home_in,
                                  Explanation& found) const {
  constexpr int kMostSteps = 12;
  constexpr double kShare = 1e-5;  ///< of chi^2 that rejects the fit: what is left of it at a kink
  const Unknowns unknowns(problem);
  const auto from = [&](const Eigen::VectorXd& start) {
    Residuals residuals = of(unknowns, start);
    residuals.set_own_errors(start);
    residuals.linearise(start);
    const Eigen::VectorXd z = home_in ? homed_in(residuals, unknowns.z(start)).z : unknowns.z(start);
    return linearised(residuals, minimise_linearised(residuals, z,
                                                     {.decrement = std::max(1e-4, kShare * best_.chi2),
                                                      .full_steps = kMostSteps}));
  };
  Eigen::VectorXd start = unknowns.values_of(unknowns_, values_);
  Minimum minimum = from(start);
  if (candidate && candidate->name == std::string_view(kStribeck) && !problem.summary_runs.empty())
    for (const double speed : {0.5 * kStribeckSpeed, kStribeckSpeed, 2 * kStribeckSpeed}) {
      start(*unknowns.find(FitParameter::stribeck)) = 0.2;
      start(*unknowns.find(FitParameter::stribeck_speed)) = speed;
      Minimum other = from(start);
      if (other.converged && !(minimum.converged && minimum.chi2 <= other.chi2)) minimum = std::move(other);
    }
  if (!minimum.converged || minimum.at.empty() || minimum.chi2 > best_.chi2 ||
      !admissible(unknowns, minimum.z))
    return {};
  const Eigen::VectorXd values = unknowns.values(minimum.z);
  const Eigen::MatrixXd covariance = uncertainty(unknowns, values, minimum.at).shared;
  found.refitted = true;
  found.chi2_fall = best_.chi2 - minimum.chi2;
  found.p_after = residuals_.p_value(minimum.chi2, found.dof);
  found.parameters = estimates_under(unknowns, values, covariance);
  const Eigen::VectorXd here = unknowns_.values_of(unknowns, values);
  if (candidate == nullptr) return here;
  if (candidate->name == std::string_view(kUnseenSpin)) {
    tell_spin(unknowns, values, minimum.at, found);
    return here;
  }
  double square = 0, variance = 0, sum = 0;
  for (const FitParameter quantity : candidate->quantities) {
    const Eigen::Index i = *unknowns.find(quantity);
    const double change = values(i) - unknowns.as_given(quantity);
    sum += change;
    square += change * change;
    variance += change * change * covariance(i, i);
  }
  if (candidate->never_negative && sum < 0) found.chi2_fall = 0;
  tell_size(*candidate, candidate->quantities.size() == 1 ? sum : std::sqrt(square),
            std::sqrt(variance / std::max(square, 1e-300)), found);
  return here;
}

std::optional<Explanation> ScoreTests::test(const Products& g) const {
  const Eigen::MatrixXd& with = g.with_unknowns;
  const Eigen::MatrixXd s = g.own - with * information_ * with.transpose();
  for (Eigen::Index i = 0; i < s.rows(); ++i)
    if (!(s(i, i) > 1e-6 * g.own(i, i))) return std::nullopt;
  const Eigen::VectorXd b = g.with_residuals - with * step_;
  const Eigen::MatrixXd covariance = inverse_symmetric(s);
  const Eigen::VectorXd size = -(covariance * b);
  Explanation found;
  found.dof = static_cast<int>(s.rows());
  found.chi2_fall = b.dot(covariance * b);
  found.size = size.size() == 1 ? size(0) : size.norm();
  found.size_sd = std::sqrt(size.dot(covariance * size)) / std::max(size.norm(), 1e-300);
  found.p_after = residuals_.p_value(std::max(0.0, best_.chi2 - found.chi2_fall), found.dof);
  const Eigen::MatrixXd back = information_ * with.transpose();
  found.parameters = estimates_under(unknowns_, values_.head(unknowns_.common()) - step_ - back * size,
                                     information_ + back * covariance * back.transpose());
  return found;
}

/// That of the fastest edge beside its slide.
void ScoreTests::tell_spin(const Unknowns& unknowns, const Eigen::VectorXd& values, const Linearised& at,
                           Explanation& found) const {
  const Eigen::MatrixXd jacobian = at.jacobian(unknowns.size());
  const Eigen::MatrixXd covariance = inverse_symmetric(jacobian.transpose() * jacobian);
  for (std::size_t i = 0; i < problem_.trajectory_runs.size(); ++i) {
    const Eigen::Index spin = unknowns.find(Nuisance::spin, i)->first;
    const double by_rate =
        unknowns.problem().trajectory_runs[i].track.radius / sliding_speed(unknowns, values, i);
    const double ratio = by_rate * std::abs(values(spin));
    if (ratio < found.size) continue;
    found.size = ratio;
    found.size_sd = by_rate * std::sqrt(covariance(spin, spin));
  }
}

/// In the candidate's unit. The prior's row is in its sd.
void ScoreTests::tell_size(const Candidate& candidate, double size, double sd, Explanation& found) const {
  const FitParameter first = candidate.quantities.front();
  double unit = candidate.per_unit > 0 ? candidate.per_unit : 100 / std::abs(unknowns_.as_given(first));
  const auto known = unknowns_.find(first);
  if (known && !found.refitted) unit *= unknowns_.prior(*known)->sd;
  found.size = unit * size;
  found.size_sd = unit * sd;
  if (first == FitParameter::gate_edges) {  // its square was the unknown
    found.size = std::sqrt(std::max(0.0, size));
    found.size_sd = found.size > 0 ? 0.5 * sd / found.size : std::sqrt(sd);
  }
}

}  // namespace tribotrack::fit::internal

#include "fit/checks/explanations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "fit/checks/run_scatter.h"
#include "fit/checks/runs.h"
#include "fit/minimum/multi_start.h"
#include "fit/rounding.h"
#include "fit/tools/dense.h"
#include "fit/tools/thresholds.h"
#include "fit/uncertainty/covariance.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit::internal {
namespace {

/// What the fit takes as exact, or as known to an sd.
struct Candidate {
  const char* name;
  const char* what;  ///< before its size
  const char* unit;
  double per_unit;  ///< of the unit, in one of the quantity's; 0: per cent of its own value
  std::vector<FitParameter> quantities;
  bool never_negative = false;
};

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
      {"stribeck", "friction that falls with speed (Stribeck)", "%", 100, {stribeck}, true},
      {"viscous", "friction that rises with speed (viscous)", "1/s", 1, {viscous}, true},
      {"mu2_speed", "a reduced friction that rises with speed", "%", 100, {mu2_speed}, true},
      {"mu2_width", "a reduced friction that changes with the width of the gate", "%/rad", 100, {mu2_width}},
      {"gate_edges", "gate edges that take their time", "rad", 1, {gate_edges}, true},
      {"static_friction", "a higher friction at rest", "%", 100, {static_friction}, true},
      {"wear", "friction that changes in the course of the campaign", "%", 100, {wear}},
      {kUnseenSpin, "a spin that was not seen", "times the sliding speed at the edge", 1, {}}};
  return all;
}

/// The same problem with quantities free that are conditions at the most.
Problem with_free(Problem problem, const std::vector<FitParameter>& quantities) {
  constexpr double kUnknown = 1e3;  ///< an sd that says nothing: of a relative value, or rad
  for (const FitParameter quantity : quantities) {
    std::erase_if(problem.conditions, [&](const Condition& c) { return c.quantity == quantity; });
    problem.prior.erase(quantity);
    const double size = std::abs(Unknowns(problem).as_given(quantity));
    const bool sized = quantity == FitParameter::amplitude || quantity == FitParameter::angular_frequency;
    problem.conditions.push_back({quantity, kUnknown * (sized ? size : 1), kSetFree});
  }
  return problem;
}

double sliding_speed(const Unknowns& unknowns, const Eigen::VectorXd& values, std::size_t slide) {
  return values.segment<2>(unknowns.find(Nuisance::velocity, slide)->first).norm();
}

/// Of slides whose spin was not seen: the edge of each moves half as fast as it slides, with an sd of as
/// much.
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

/// Products of columns G with themselves, with J and with r.
struct Products {
  Eigen::MatrixXd own, with_unknowns;  ///< G'G, G'J
  Eigen::VectorXd with_residuals;      ///< G'r
};

class ScoreTests {
 public:
  ScoreTests(const Residuals& residuals, const Minimum& best, int threads)
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
  bool empty() const { return at_.empty(); }

  /// To first order; nullopt where it is fitted anyway, or the data do not see it beside the unknowns.
  std::optional<Explanation> test(const Candidate& candidate) const {
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

  /// A run's two numbers, as if it had not been measured.
  std::optional<Explanation> test_run(std::size_t run) const {
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

  /// Friction that differs from run to run.
  std::optional<Explanation> test_scatter() const {
    const auto scatter = run_scatter(of(wide_, values_), wide_.values_of(unknowns_, values_), at_);
    if (!scatter) return std::nullopt;
    Explanation found = scatter_of(100 * scatter->relative, 2 * problem_.summary_runs.size());
    found.chi2_fall = scatter->fall;
    found.p_after = residuals_.p_value(scatter->chi2, 1);
    found.parameters = estimates_under(unknowns_, values_, information_);
    return found;
  }

  /// The fit in another problem of the same runs, from here or homed in. Where it ends, for this one's
  /// unknowns; empty where it fails.
  Eigen::VectorXd refit(const Problem& problem, const Candidate* candidate, bool home_in,
                        Explanation& found) const {
    constexpr int kMostSteps = 12;
    constexpr double kShare = 1e-5;  ///< of chi^2 that rejects the fit: what is left of it at a kink
    const Unknowns unknowns(problem);
    const Eigen::VectorXd start = unknowns.values_of(unknowns_, values_);
    Residuals residuals = of(unknowns, start);
    residuals.set_own_errors(start);
    residuals.linearise(start);
    const Eigen::VectorXd from = home_in ? homed_in(residuals, unknowns.z(start)).z : unknowns.z(start);
    const Minimum minimum = linearised(
        residuals,
        minimise_linearised(residuals, from,
                            {.decrement = std::max(1e-4, kShare * best_.chi2), .full_steps = kMostSteps}));
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

 private:
  /// Slides have no viscous part of their own here, which would leave nothing to the one of all.
  Problem with_all_free() const {
    Problem problem = with_free(problem_, not_yet_unknown());
    problem.between_viscous_slides = {};
    return problem;
  }
  std::vector<FitParameter> not_yet_unknown() const {
    std::vector<FitParameter> free;
    for (const Candidate& candidate : candidates())
      for (const FitParameter quantity : candidate.quantities)
        if (!unknowns_.find(quantity)) free.push_back(quantity);
    return free;
  }
  Products products(Eigen::Index size) const {
    return {Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, unknowns_.common()),
            Eigen::VectorXd::Zero(size)};
  }
  Residuals of(const Unknowns& unknowns, const Eigen::VectorXd& values) const {
    Residuals rows(unknowns, threads_);
    rows.set_tolerance(1e-8);
    rows.set_excess_variance(residuals_.excess_variance());
    rows.set_own_errors(unknowns.values_of(unknowns_, values));
    return rows;
  }

  std::optional<Explanation> test(const Products& g) const {
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
  void tell_spin(const Unknowns& unknowns, const Eigen::VectorXd& values, const Linearised& at,
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
  void tell_size(const Candidate& candidate, double size, double sd, Explanation& found) const {
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

  const Residuals& residuals_;
  const Unknowns& unknowns_;
  const Problem& problem_;
  const Minimum& best_;
  int threads_;
  Eigen::VectorXd values_;
  Problem wide_problem_;  ///< everything free
  Unknowns wide_;
  Linearised at_;
  Eigen::MatrixXd normal_, information_;
  Eigen::VectorXd gradient_, step_;
  std::vector<Eigen::Index> columns_;  ///< of the fit's own unknowns
};

/// The worst of many runs is found by chance more easily.
double gain(const Explanation& found, std::size_t runs) {
  const double chosen = found.name == "bad_run" ? 2 * std::log(static_cast<double>(runs)) : 0;
  return gain_of(found) - chosen;
}

/// Runs that may be bad: the one without which chi^2 falls most, and the one of which that is true where the
/// model is taken to be good to a tenth only. For with small errors a bad run takes the minimum with it, and
/// others look worse there.
std::vector<std::size_t> suspects(const Residuals& residuals, const Minimum& best, bool rejected) {
  constexpr double kRough[] = {0.1};
  const Problem& problem = residuals.unknowns().problem();
  std::vector<bool> out;
  for (const SummaryRun& run : problem.summary_runs) out.push_back(run.held_out);
  if (out.size() < 4) return {};
  std::vector<std::size_t> found;
  const auto look_at = [&](const Minimum& minimum) {
    if (minimum.at.empty()) return;
    const auto [run, fall] = worst_run(residuals.unknowns(), minimum, out);
    if (fall > 0 && std::ranges::count(found, run) == 0) found.push_back(run);
  };
  look_at(linearised(residuals, best));
  if (rejected && residuals.linear_in_conditions()) look_at(homed_in(residuals, best.z, kRough));
  return found;
}

/// Of free slides alone: how many of their numbers are independent. Their points err alike beyond what they
/// tell, so that no law leaves chi^2 as it should be; of errors of an unknown size that many numbers say a
/// law is likelier where chi^2 falls by a share, by n ln of the ratio. 0 where there are driven runs.
double independent_points(const Residuals& residuals, Minimum best) {
  const Problem& problem = residuals.unknowns().problem();
  best = linearised(residuals, std::move(best));
  if (!problem.summary_runs.empty() || best.at.empty() || problem.has_driven_tracks()) return 0;
  const ExcessVariance excess =
      estimate_excess_variance(residuals, residuals.unknowns().values(best.z), best.at);
  constexpr double kOwn = 5;  ///< numbers of each slide that place, velocity and mu1 take
  double count = 0;
  for (std::size_t i = 0; i < excess.trajectories.size(); ++i)
    count += std::max(
        0.0, 2 * static_cast<double>(residuals.track(i).points()) / excess.trajectories[i].correlation_time -
                 kOwn);
  return count;
}

/// One thing for all slides, where a spin of each describes nearly anything about as well.
bool shared(const Explanation& found) {
  return found.name != kUnseenSpin || found.dof == 1;
}

/// Laws and spins brake nearly alike: of slides none is the cause alone that is not much likelier than
/// others. What they share comes first; spins of each count beside it where it leaves something to explain.
void weigh_causes_of_slides(std::vector<ExplainedProblem>& list) {
  const auto rank = [](const ExplainedProblem& e) {
    return std::tuple(e.found.explains, shared(e.found), e.found.p_after > kExplained, e.gain);
  };
  const auto first = std::ranges::max_element(list, {}, rank);
  if (first == list.end() || !first->found.explains) return;
  const double most = first->gain;
  const bool explained = first->found.p_after > kExplained;
  for (ExplainedProblem& other : list) {
    const bool near = other.gain > std::max(0.0, most - kPreferred);
    other.found.explains =
        other.found.refitted &&
        (shared(other.found) ? near : other.found.p_after > kExplained && (!explained || near));
    if (other.found.explains) other.gain = most;
  }
  std::rotate(list.begin(), first, first + 1);
}

}  // namespace

std::string sentence_of(const Explanation& e) {
  if (e.name == "bad_run") return "run '" + e.run + "', which contradicts the others";
  const auto found = std::ranges::find(candidates(), e.name, &Candidate::name);
  const char* what = found == candidates().end() ? "friction that differs from run to run" : found->what;
  return fmt::format("{} ({} {})", what, quoted(e.size, e.size_sd), e.unit);
}

std::vector<ExplainedProblem> explanations(const Residuals& residuals, const Minimum& best, bool rejected,
                                           int threads) {
  const Problem& problem = residuals.unknowns().problem();
  const std::size_t runs = problem.summary_runs.size();
  const ScoreTests tests(residuals, best, threads);
  if (tests.empty()) return {};
  struct Tested {
    Explanation found;
    std::function<Problem()> problem;
    const Candidate* candidate;
    Eigen::VectorXd values = {};
  };
  std::vector<Tested> list;
  for (const Candidate& candidate : candidates())
    if (auto found = tests.test(candidate))
      list.push_back(
          {std::move(*found), [&] { return with_free(problem, candidate.quantities); }, &candidate});
  for (const std::size_t run : suspects(residuals, best, rejected))
    if (auto found = tests.test_run(run))
      list.push_back({std::move(*found),
                      [&, run] {
                        Problem without = problem;
                        without.summary_runs[run].held_out = true;
                        return without;
                      },
                      nullptr});
  if (auto scatter = tests.test_scatter())  // it takes the minimum with it: found by a search of its own
    list.push_back({std::move(*scatter), nullptr, nullptr});

  const auto better = [&](const Tested& a, const Tested& b) {
    return gain(a.found, runs) > gain(b.found, runs);
  };
  std::stable_sort(list.begin(), list.end(), better);
  if (rejected) {
    constexpr double kWorthAFit = 0.2;  ///< of the best's gain
    constexpr std::size_t kMostFits = 6;
    const double most = list.empty() ? 0 : gain(list.front().found, runs);
    // A fit to tracks takes long: of what explains them a half shows to first order.
    const double excess = problem.has_driven_tracks() ? best.chi2 - residuals.degrees_of_freedom() : 0;
    const double least = std::max({9.0, kWorthAFit * most, 0.5 * excess});
    for (std::size_t i = 0; i < list.size(); ++i) {
      const bool bad_run = list[i].found.name == "bad_run";
      if (!list[i].problem) continue;
      if (bad_run || (i < kMostFits && gain(list[i].found, runs) > least))
        list[i].values = tests.refit(list[i].problem(), list[i].candidate, bad_run, list[i].found);
    }
    if (const auto spinning =
            with_unseen_spin(problem, residuals.unknowns(), residuals.unknowns().values(best.z))) {
      Tested spin{{}, [spinning] { return *spinning; }, &candidates().back()};
      spin.found.name = kUnseenSpin;
      spin.found.unit = spin.candidate->unit;
      spin.found.dof = static_cast<int>(spinning->trajectory_runs.size());
      spin.values = tests.refit(*spinning, spin.candidate, false, spin.found);
      if (spin.found.refitted) list.push_back(std::move(spin));
    }
    std::stable_sort(list.begin(), list.end(), better);
  }
  const auto is_bad_run = [](const Tested& tested) { return tested.found.name == "bad_run"; };
  if (const auto worst = std::ranges::find_if(list, is_bad_run); worst != list.end())
    list.erase(std::remove_if(worst + 1, list.end(), is_bad_run), list.end());
  const double of_slides = independent_points(residuals, best);
  std::vector<ExplainedProblem> result;
  for (Tested& tested : list) {
    Explanation& found = tested.found;
    const double left = best.chi2 - found.chi2_fall;
    const double likelier =
        (of_slides > 0 && left > 0 ? of_slides * std::log(best.chi2 / left) : found.chi2_fall) -
        2 * found.dof;
    const bool by_likelihood = of_slides > 0 && likelier > kPreferred && shared(found);
    found.explains = rejected && found.refitted && gain(found, runs) > kPreferred &&
                     (found.p_after > kExplained || by_likelihood);
    result.push_back({found, found.refitted ? tested.problem() : Problem{}, tested.values, likelier});
  }
  if (of_slides > 0) weigh_causes_of_slides(result);
  return result;
}

}  // namespace tribotrack::fit::internal

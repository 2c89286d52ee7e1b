#include "fit/uncertainty/budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "fit/tools/dense.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/parameters.h"

namespace tribotrack::fit::internal {
namespace {

constexpr const char* kTracking = "tracking noise";
constexpr const char* kShared = "errors common to frames";
constexpr const char* kOwn = "gate and phase of single runs";
constexpr const char* kFriction = "friction, gate and phase of single runs";
constexpr const char* kScatter = "scatter between runs";
constexpr const char* kSpin = "spin of slides";
constexpr const char* kSlides = "differences between slides";
constexpr const char* kStartPhase = "phase at the start of single runs";
constexpr const char* kExact = "taken as exact";
/// A contribution below this share of every sd is not worth a line.
constexpr double kNegligible = 1e-3;

std::string source_name(FitParameter quantity) {
  const char* const source = facts(quantity).source;
  return source != nullptr ? source : std::string("prior of ") + to_string(quantity);
}

/// An error to imagine in what was taken as exact, SI.
double assumed_error(FitParameter quantity, double value) {
  if (facts(quantity).sort == Sort::phase) return 0.01;
  if (facts(quantity).sort == Sort::tilt) return 1e-3;
  return 0.01 * std::abs(value);
}

/// From one quantity with so large an error.
BudgetEntry of_quantity(FitParameter quantity, double sd, const std::string& from,
                        const Eigen::VectorXd& sensitivity) {
  return {source_name(quantity), to_string(quantity),         sd,         from,
          from != kExact,        sensitivity.cwiseAbs() * sd, sensitivity};
}

class Sources {
 public:
  Sources(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty)
      : residuals_(residuals),
        unknowns_(residuals.unknowns()),
        problem_(unknowns_.problem()),
        best_(best),
        uncertainty_(uncertainty),
        n_(unknowns_.reported()) {
    for (const RowGroup& group : best.at.eliminated().groups)
      by_rows_.emplace_back(-uncertainty.shared.topRows(n_) * group.shared.transpose());
  }

  std::vector<BudgetEntry> counted() {
    summary_runs();
    trajectory_runs();
    conditions_and_priors();
    std::erase_if(entries_, [&](const BudgetEntry& entry) { return negligible(entry.contribution); });
    std::stable_sort(entries_.begin(), entries_.end(), [&](const BudgetEntry& a, const BudgetEntry& b) {
      return weight(a.contribution) > weight(b.contribution);
    });
    return std::move(entries_);
  }

  /// Sensitivities to what is neither fitted nor a condition, from the exact derivatives.
  std::vector<BudgetEntry> taken_as_exact() const {
    Problem all = problem_;
    std::vector<FitParameter> exact;
    for (const FitParameter quantity :
         {FitParameter::amplitude, FitParameter::amplitude_ratio, FitParameter::angular_frequency,
          FitParameter::phase_shift, FitParameter::phase_reference, FitParameter::scale,
          FitParameter::gravity, FitParameter::tilt_x, FitParameter::tilt_y, FitParameter::slope,
          FitParameter::start_phase}) {
      if (unknowns_.is_known(quantity)) continue;
      exact.push_back(quantity);
      all.conditions.push_back({quantity, 1, ""});
    }
    const Unknowns wide(all);
    const auto at = evaluated(wide, wide.values_of(unknowns_, unknowns_.values(best_.z)));
    std::vector<BudgetEntry> entries;
    if (!at) return entries;
    for (const FitParameter quantity : exact) {
      Eigen::VectorXd sensitivity = Eigen::VectorXd::Zero(n_);
      for (std::size_t g = 0; g < by_rows_.size(); ++g) {
        // Without the prior of the quantity, which stands in the first group behind the data.
        const Eigen::Index rows = g == 0 ? data_rows() : by_rows_[g].cols();
        sensitivity += by_rows_[g].leftCols(rows) * at->groups[g].shared.col(*wide.find(quantity)).head(rows);
      }
      const BudgetEntry entry =
          of_quantity(quantity, assumed_error(quantity, wide.as_given(quantity)), kExact, sensitivity);
      if (!negligible(entry.contribution)) entries.push_back(entry);
    }
    for (const auto& [quantity, name] : problem_.exact) {
      const auto unknown = unknowns_.find(quantity);
      if (!unknown || *unknown < n_) continue;
      const double sd = unknowns_.prior(*unknown)->sd;
      entries.push_back(of_quantity(quantity, assumed_error(quantity, unknowns_.as_given(quantity)), kExact,
                                    uncertainty_.shared.col(*unknown).head(n_) / (sd * sd)));
      entries.back().source += " by " + name;
    }
    return entries;
  }

 private:
  /// The rows of another problem of the same runs, whitened as these.
  std::optional<Linearised> evaluated(const Unknowns& unknowns, const Eigen::VectorXd& values) const {
    Residuals rows(unknowns);
    rows.set_tolerance(1e-7);
    rows.set_excess_variance(residuals_.excess_variance());
    rows.set_weights(residuals_.weights());
    rows.set_own_errors(values);
    return rows.at(values);
  }

  Eigen::Index data_rows() const { return static_cast<Eigen::Index>(2 * problem_.summary_runs.size()); }

  /// Sum over the parameters of shares of the variance.
  double weight(const Eigen::VectorXd& contribution) const {
    return (contribution.array().square() / uncertainty_.covariance.diagonal().array().max(1e-300)).sum();
  }
  bool negligible(const Eigen::VectorXd& contribution) const {
    return weight(contribution) < kNegligible * kNegligible;
  }

  /// `variance`: of each parameter.
  void add(const char* source, const Eigen::VectorXd& variance, const std::string& from = "") {
    const auto place = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const BudgetEntry& entry) { return entry.source == source; });
    BudgetEntry& entry = place == entries_.end() ? entries_.emplace_back() : *place;
    entry.source = source;
    entry.from = from;
    if (entry.contribution.size() == 0) entry.contribution = Eigen::VectorXd::Zero(n_);
    entry.contribution =
        (entry.contribution.array().square() + variance.array().max(0)).sqrt();  // of independent errors
  }

  void summary_runs() {
    for (std::size_t i = 0; i < problem_.summary_runs.size(); ++i) {
      const auto row = 2 * static_cast<Eigen::Index>(i);
      const Eigen::Matrix2d all = residuals_.covariance(i);
      // Rows are whitened by L^-1: to the parameters per metre of displacement.
      const Eigen::MatrixX2d by_metre =
          std::sqrt(residuals_.weight(i)) *
          Factor2(all).by_upper(by_rows_[0].middleCols(row, 2).transpose()).transpose();
      const auto variance = [&](const Eigen::Matrix2d& covariance) {
        return Eigen::VectorXd((by_metre * covariance * by_metre.transpose()).diagonal());
      };
      const Eigen::Matrix2d measured = problem_.summary_runs[i].measured.covariance,
                            own = residuals_.own_error(i);
      add(kTracking, variance(measured), "the runs' own sds");
      add_own(variance(own));
      add(kScatter, variance(all - measured - own), "residuals of the fit");
    }
  }

  /// Points by their rows, phases, spins and deviations of single runs by the rows of their priors.
  void trajectory_runs() {
    if (problem_.trajectory_runs.empty()) return;
    std::vector<Eigen::MatrixXd> points = by_rows_;
    for (std::size_t i = 0; i < problem_.trajectory_runs.size(); ++i) {
      const std::size_t group = 1 + i;
      Eigen::Index row = residuals_.layout().groups[group].data;
      for (const NuisanceBlock& block : unknowns_.nuisances(i)) {
        const Eigen::Index rows = block.known.rows();
        add_nuisance(block.kind, by_rows_[group].middleCols(row, rows).rowwise().squaredNorm());
        points[group].middleCols(row, rows).setZero();
        row += rows;
      }
    }
    Eigen::VectorXd noise = Eigen::VectorXd::Zero(n_), all = noise;
    for (std::size_t g = 1; g < points.size(); ++g)
      for (Eigen::Index p = 0; p < n_; ++p) {
        Eigen::VectorXd by_row = points[g].row(p);
        all(p) += by_row.squaredNorm();
        residuals_.track(g - 1).take_own(by_row.head(residuals_.layout().groups[g].data));
        noise(p) += by_row.squaredNorm();
      }
    add(kTracking, noise, "the points' own sds");
    add(kShared, all - noise, "tracks and their residuals");
  }

  void add_own(const Eigen::VectorXd& variance) {
    const bool friction = problem_.counts_run_scatter();
    add(friction ? kFriction : kOwn, variance,
        friction ? "how much runs differ" : "lamp, trace, or marker of each run");
  }

  void add_nuisance(Nuisance kind, const Eigen::VectorXd& variance) {
    // A velocity is not known beforehand.
    if (kind == Nuisance::phase) add(kStartPhase, variance, "marker of each run");
    if (kind == Nuisance::own) add_own(variance);
    if (kind == Nuisance::spin) add(kSpin, variance, "angle seen in each slide");
    if (kind == Nuisance::deviation) add(kSlides, variance, "slides one by one");
  }

  void conditions_and_priors() {
    for (Eigen::Index i = 0; i < unknowns_.common(); ++i) {
      const auto prior = unknowns_.prior(i);
      if (!prior) continue;
      const FitParameter quantity = unknowns_.parameter(i);
      const Eigen::VectorXd by_value = uncertainty_.shared.col(i).head(n_) / (prior->sd * prior->sd);
      const auto place = [&](double sd, const std::string& from) {
        entries_.push_back(of_quantity(quantity, sd, from, by_value));
      };
      if (problem_.prior.count(quantity) > 0)
        place(prior->sd, "[fit.prior]");
      else
        for (const Condition& condition : problem_.conditions)
          if (condition.quantity == quantity && condition.sd > 0) place(condition.sd, condition.from);
    }
  }

  const Residuals& residuals_;
  const Unknowns& unknowns_;
  const Problem& problem_;
  const Minimum& best_;
  const Uncertainty& uncertainty_;
  Eigen::Index n_;
  std::vector<Eigen::MatrixXd> by_rows_;  ///< d parameters / d rows, of each group
  std::vector<BudgetEntry> entries_;
};

const char* advice(const BudgetEntry& entry) {
  const std::string& source = entry.source;
  if (source == kTracking) return "film more runs or more cycles, or the part larger in the picture";
  if (source == kShared) return "look at lens, light and focus, or film more runs";
  if (source == kOwn) return "film a gate lamp at a higher rate, or more cycles of it";
  if (source == kFriction)
    return "film more runs, or each several times, with part and platform cleaned alike";
  if (source == kScatter) return "repeat runs: they differ by more than tracking explains";
  if (source == kSlides) return "film more slides";
  if (source == kSpin) return "mark the part so that its turning is seen, or start it without spin";
  if (source == kStartPhase) return "film more cycles of the marker before the part starts";
  if (entry.quantity == to_string(FitParameter::scale))
    return "measure the part's diameter and chamfer better, or give the scale by a tag or a calibration";
  if (entry.quantity == to_string(FitParameter::phase_reference))
    return "film a gate lamp (gate_px), or calibrate where the phase sensor fires";
  return "measure it better, or in more runs";
}

}  // namespace

std::vector<BudgetEntry> budget(const Residuals& residuals, const Minimum& best,
                                const Uncertainty& uncertainty) {
  if (uncertainty.rank < residuals.unknowns().reported() || best.at.empty()) return {};
  Sources sources(residuals, best, uncertainty);
  std::vector<BudgetEntry> entries = sources.counted();
  for (BudgetEntry& entry : sources.taken_as_exact()) entries.push_back(std::move(entry));
  return entries;
}

std::vector<std::string> taken_as_exact(const std::vector<BudgetEntry>& budget,
                                        const std::vector<ParameterEstimate>& parameters) {
  std::vector<std::string> sentences;
  for (const BudgetEntry& entry : budget) {
    if (entry.counted || entry.sensitivity.size() == 0) continue;
    const bool angle = entry.quantity.ends_with("_rad");
    std::string text = fmt::format("{} ({}) is taken as exact; with {} more of it: ", entry.source,
                                   entry.quantity, angle ? number(entry.sd, 2) + " rad" : std::string("1 %"));
    std::string changes;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const double change = entry.sensitivity(static_cast<Eigen::Index>(i)) * entry.sd;
      if (std::abs(change) < kNegligible * parameters[i].sd) continue;
      changes += (changes.empty() ? "" : ", ") +
                 change_text(parameters[i].parameter, change, parameters[i].estimate);
    }
    sentences.push_back(text + changes + ".");
  }
  return sentences;
}

std::string improve_first(const std::vector<BudgetEntry>& budget,
                          const std::vector<ParameterEstimate>& parameters) {
  if (budget.empty() || !budget.front().counted) return "";
  const BudgetEntry& largest = budget.front();
  std::string shares;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double share = std::pow(largest.contribution(static_cast<Eigen::Index>(i)) / parameters[i].sd, 2);
    if (share < 0.01) continue;
    shares += fmt::format("{}{:.0f} % of {}{}", shares.empty() ? "" : ", ", 100 * std::min(1.0, share),
                          shares.empty() ? "the variance of " : "", to_string(parameters[i].parameter));
  }
  return fmt::format("Improve first: {} ({}): {}.", largest.source, shares, advice(largest));
}

}  // namespace tribotrack::fit::internal

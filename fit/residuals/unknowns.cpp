#include "fit/residuals/unknowns.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>

#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {

using model::Parameter;

namespace {

/// Of the optimiser's axis, where that is not logarithmic.
double unit_of(FitParameter parameter, double w, double threshold) {
  if (parameter == FitParameter::mu2) return 0.05 * threshold;
  if (parameter == FitParameter::delay) return 1 / w;
  return facts(parameter).sort == Sort::tilt ? 0.01 : 1;
}

const std::vector<Eigen::Index> kNone;

/// A number with its derivatives by the unknowns of a run: those that all runs share, then the run's own.
using Number = Eigen::AutoDiffScalar<Eigen::VectorXd>;

/// The parameters of a run's scenario as its unknowns make them, with their derivatives.
class Setting {
 public:
  /// `own`: the unknowns of the run alone. Derivatives are by these and by those of the others that `by`
  /// lists, if it lists any.
  Setting(const Unknowns& unknowns, const Eigen::VectorXd& values, const model::Scenario& base, Range own,
          const std::vector<Eigen::Index>& by)
      : scenario(base), unknowns_(unknowns), values_(values), own_(own), by_(by) {
    constexpr auto kParameters = static_cast<Eigen::Index>(Parameter::viscous) + 1;
    chain_.setZero(kParameters, by.empty() ? 0 : unknowns.common() + own.count);
  }

  model::Scenario scenario;
  Number operator[](Parameter parameter) const {
    return {scenario.get(parameter), chain_.row(static_cast<Eigen::Index>(parameter))};
  }
  void set(Parameter parameter, const Number& number) {
    scenario.set(parameter, number.value());
    chain_.row(static_cast<Eigen::Index>(parameter)) = number.derivatives();
  }
  void add(Parameter parameter, const Number& more) { set(parameter, (*this)[parameter] + more); }
  /// What is given, where it is fitted or fixed.
  void replace(Parameter given, FitParameter by) {
    if (unknowns_.is_known(by)) set(given, of(by));
  }

  Number constant(double value) const { return {value, Eigen::VectorXd::Zero(chain_.cols())}; }
  /// Fitted, fixed, or as given.
  Number of(FitParameter parameter) const {
    Number number = constant(unknowns_.value_of(parameter, values_));
    if (const auto i = unknowns_.find(parameter); i && std::ranges::count(by_, *i) > 0)
      number.derivatives()(*i) = 1;
    return number;
  }
  /// Of the run alone.
  Number own(Eigen::Index unknown) const {
    Number number = constant(values_(unknown));
    if (!by_.empty()) number.derivatives()(unknowns_.common() + unknown - own_.first) = 1;
    return number;
  }

  /// Each of the model's parameters costs time: those that nothing moves, or that move nothing, are left out.
  AppliedScenario applied() const {
    AppliedScenario result;
    result.scenario = scenario;
    result.scale = unknowns_.value_of(FitParameter::scale, values_);
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < chain_.rows(); ++k) {
      const auto parameter = static_cast<Parameter>(k);
      if (chain_.row(k).isZero(0) || moves_nothing(parameter)) continue;
      result.wanted.push_back(parameter);
      rows.push_back(k);
    }
    result.chain = chain_(rows, Eigen::all);
    return result;
  }

 private:
  bool moves_nothing(Parameter parameter) const {
    const bool of_pulses = parameter == Parameter::mu2 || parameter == Parameter::lag;
    return (of_pulses && !(scenario.friction.pulse_width > 0)) ||
           (parameter == Parameter::phase_shift && !(scenario.drive.amplitude_y > 0));
  }

  const Unknowns& unknowns_;
  const Eigen::VectorXd& values_;
  Range own_;
  const std::vector<Eigen::Index>& by_;
  Eigen::MatrixXd chain_;  ///< of every parameter, in the order of the enumeration
};

/// By what all runs share.
void apply_shared(const Reference& reference, bool amplitude_from_track, Setting& run) {
  const model::Scenario base = run.scenario;
  // Amplitude and frequency are those of the first driven run; the others keep their ratio to it.
  Number amplitude = run.constant(1);
  if (reference.amplitude > 0) amplitude = run.of(FitParameter::amplitude) / reference.amplitude;
  if (amplitude_from_track) amplitude *= run.of(FitParameter::scale);
  // Each takes a half of the ratio: measured alike, mean and ratio are not correlated.
  const Number root = sqrt(run.of(FitParameter::amplitude_ratio));
  run.set(Parameter::amplitude, amplitude / root * base.drive.amplitude);
  run.set(Parameter::amplitude_y, amplitude * root * base.drive.amplitude_y);
  const double frequency_ratio = base.drive.angular_frequency / reference.angular_frequency;
  const Number w = run.of(FitParameter::angular_frequency) * frequency_ratio;
  run.set(Parameter::angular_frequency, w);

  run.set(Parameter::mu1, run.of(FitParameter::mu1));
  run.set(Parameter::mu2, run.of(FitParameter::mu2));
  // Along an open profile mu goes to infinity: a part that rests does so at any greater one as well.
  constexpr double kRestsUnderAnyDrive = 1e9;
  model::Friction& friction = run.scenario.friction;
  friction.nominal = std::min(friction.nominal, kRestsUnderAnyDrive);
  friction.reduced = std::min(friction.reduced, kRestsUnderAnyDrive);
  run.set(Parameter::lag, run.of(FitParameter::lag) + w * run.of(FitParameter::delay) +
                              run.of(FitParameter::phase_reference));
  run.add(Parameter::phase_shift, run.of(FitParameter::phase_shift));
  if (base.start == model::Start::rest && reference.amplitude > 0)
    run.add(Parameter::start_phase, run.of(FitParameter::start_phase));
  run.replace(Parameter::tilt_x, FitParameter::tilt_x);
  run.replace(Parameter::tilt_y, FitParameter::tilt_y);
  run.replace(Parameter::gravity, FitParameter::gravity);
}

/// mu1 and mu2 as the width of the gate, so much `wider` than usual, and the course of the campaign change
/// them. Exponentials: friction is never negative.
void change_friction(double wider, double course, Setting& run) {
  const Number worn = exp(run.of(FitParameter::wear) * course);
  run.set(Parameter::mu1, run[Parameter::mu1] * worn);
  run.set(Parameter::mu2, run[Parameter::mu2] * worn * exp(run.of(FitParameter::mu2_width) * wider));
}

/// A part on a plane tilted by theta moves as one on a level platform that is pressed with g cos(theta) and
/// pulled with g sin(theta) = g cos(theta) tan(theta) downhill. That tilt stands for the platform's.
void lean(const TrajectoryRun& slide, Setting& run) {
  Number theta = run.of(FitParameter::slope);
  theta += std::abs(slide.slope);
  run.set(Parameter::gravity, run[Parameter::gravity] * cos(theta));
  run.set(Parameter::tilt_x, asin(tan(theta) * slide.downhill.x()));
  run.set(Parameter::tilt_y, asin(tan(theta) * slide.downhill.y()));
}

}  // namespace

Unknowns::Unknowns(const Problem& problem)
    : problem_(&problem), common_(problem.free), reference_(reference_of(problem)) {
  std::size_t pulsed = 0;
  const auto count_width = [&](const model::Scenario& scenario) {
    if (!(scenario.friction.pulse_width > 0)) return;
    mean_width_ += (scenario.friction.pulse_width - mean_width_) / static_cast<double>(++pulsed);
  };
  for (const auto& run : problem.summary_runs) count_width(run.scenario);
  for (const auto& run : problem.trajectory_runs) count_width(run.scenario);

  for (const Condition& condition : problem.conditions)
    if (condition.sd > 0 && !find(condition.quantity)) common_.push_back(condition.quantity);
  for (Eigen::Index i = 0; i < common(); ++i) shared_.push_back(i);
  const double threshold = sliding_threshold().value_or(0.2);
  for (const auto parameter : common_)
    transforms_.emplace_back(facts(parameter).transform,
                             unit_of(parameter, reference_frequency(), threshold));

  const auto add = [&](Nuisance kind, std::size_t run, const Eigen::VectorXd& guess,
                       const Eigen::VectorXd& scale, const Eigen::MatrixXd& known = {}) {
    nuisances_.push_back({kind, run, size(), guess, scale, known});
    for (const double unit : scale) transforms_.emplace_back(Transform::Kind::linear, unit);
    own_[run].count += scale.size();
  };
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  double fastest = 0;  // of the slides
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    const TrajectoryRun& run = problem.trajectory_runs[i];
    own_.push_back({size(), 0});
    if (!run.free_slide) {
      if (run.start_phase_sd > 0)
        add(Nuisance::phase, i, one(0), one(run.start_phase_sd), one(1 / run.start_phase_sd));
      const Eigen::MatrixXd& errors = run.own.covariance;
      if (!run.own.parameters.empty())
        add(Nuisance::own, i, Eigen::VectorXd::Zero(errors.rows()), errors.diagonal().cwiseSqrt(),
            Factor(errors).whitened(Eigen::MatrixXd::Identity(errors.rows(), errors.rows())));
      continue;
    }
    const FreeSlideGuess guess = guess_free_slide(run);
    if (!slide_mu_) slide_mu_ = guess.mu;
    const double speed = std::max(guess.velocity.norm(), 1e-6);
    fastest = std::max(fastest, speed);
    add(Nuisance::velocity, i, guess.velocity, Eigen::Vector2d::Constant(speed));
    if (run.spin)
      add(Nuisance::spin, i, Eigen::Vector2d(run.spin->rate, run.spin->bearing),
          Eigen::Vector2d(speed / run.track.radius, 1), Factor2(run.spin->covariance).inverse_lower());
    const auto& under_law = problem.between_viscous_slides;
    if (find(FitParameter::viscous) && under_law.mu1 > 0 && under_law.viscous > 0) {
      const Eigen::Vector2d sd(under_law.mu1, under_law.viscous);
      add(Nuisance::deviation, i, Eigen::Vector2d::Zero(), sd,
          sd.cwiseInverse().asDiagonal().toDenseMatrix());
    } else if (problem.between_slides > 0 && find(FitParameter::mu1)) {
      add(Nuisance::deviation, i, one(0), one(problem.between_slides), one(1 / problem.between_slides));
    }
  }
  const double platform = reference_.amplitude * reference_.angular_frequency;
  speed_ = platform > 0 ? platform : fastest;
}

std::optional<Eigen::Index> Unknowns::find(FitParameter parameter) const {
  const auto place = std::find(common_.begin(), common_.end(), parameter);
  if (place == common_.end()) return std::nullopt;
  return place - common_.begin();
}

std::span<const NuisanceBlock> Unknowns::nuisances(std::size_t run) const {
  return std::ranges::equal_range(nuisances_, run, {}, &NuisanceBlock::run);
}

const NuisanceBlock* Unknowns::find(Nuisance kind, std::size_t run) const {
  const auto blocks = nuisances(run);
  const auto place = std::ranges::find(blocks, kind, &NuisanceBlock::kind);
  return place == blocks.end() ? nullptr : &*place;
}

Eigen::VectorXd Unknowns::mapped(double (Transform::*by)(double) const, const Eigen::VectorXd& from) const {
  Eigen::VectorXd result(size());
  for (Eigen::Index i = 0; i < size(); ++i) result(i) = (transform(i).*by)(from(i));
  return result;
}

Eigen::VectorXd Unknowns::natural_units(const Eigen::VectorXd& values) const {
  const double mu1 = std::max(value_of(FitParameter::mu1, values), 1e-6);
  Eigen::VectorXd units(size());
  for (Eigen::Index i = 0; i < common(); ++i) {
    const FitParameter unknown = parameter(i);
    if (unknown == FitParameter::delay)
      units(i) = 1 / reference_.angular_frequency;
    else if (unknown == FitParameter::tilt_x || unknown == FitParameter::tilt_y)
      units(i) = mu1;
    else if (unknown == FitParameter::mu2)
      units(i) = std::max(values(i), 0.05 * mu1);
    else
      units(i) = transform(i).positive() ? std::abs(values(i)) : 1;
  }
  double speed = 0;
  for (const NuisanceBlock& block : nuisances_) {
    auto here = units.segment(block.first, block.size());
    switch (block.kind) {
      case Nuisance::velocity:
        speed = std::max(values.segment<2>(block.first).norm(), 1e-9);
        here.setConstant(speed);
        break;
      case Nuisance::spin:  // behind the velocity
        here << speed / problem_->trajectory_runs[block.run].track.radius, 1;
        break;
      case Nuisance::deviation:
        here.setOnes();  // 1/s of the viscous part
        here(0) = mu1;
        break;
      case Nuisance::phase:
        here.setOnes();
        break;
      case Nuisance::own:
        here = block.scale;
    }
  }
  return units;
}

Eigen::VectorXd Unknowns::values_of(const Unknowns& other, const Eigen::VectorXd& values) const {
  Eigen::VectorXd result(size());
  for (Eigen::Index i = 0; i < common(); ++i) {
    const auto there = other.find(parameter(i));
    result(i) = there ? values(*there) : as_given(parameter(i));
  }
  for (const NuisanceBlock& block : nuisances_) {
    const NuisanceBlock* there = other.find(block.kind, block.run);
    result.segment(block.first, block.size()) = block.guess;
    if (!there) continue;
    const Eigen::Index both = std::min(block.size(), there->size());
    result.segment(block.first, both) = values.segment(there->first, both);
  }
  return result;
}

Eigen::VectorXd Unknowns::first_guess() const {
  const double threshold = sliding_threshold().value_or(slide_mu_.value_or(0.2));
  Eigen::VectorXd guess = Eigen::VectorXd::Zero(size());
  // mu1 first: mu2 is guessed from it.
  const auto own = [&](FitParameter parameter) -> std::optional<double> {
    if (const auto it = problem_->start.find(parameter); it != problem_->start.end()) return it->second;
    if (const auto it = problem_->prior.find(parameter); it != problem_->prior.end()) return it->second.mean;
    return std::nullopt;
  };
  double mu1 = slide_mu_.value_or(0.8 * threshold);
  if (const auto it = problem_->fixed.find(FitParameter::mu1); it != problem_->fixed.end()) mu1 = it->second;
  mu1 = own(FitParameter::mu1).value_or(mu1);
  for (Eigen::Index i = 0; i < common(); ++i) {
    double value = as_given(parameter(i));
    if (parameter(i) == FitParameter::mu1) value = mu1;
    if (parameter(i) == FitParameter::mu2) value = 0.2 * mu1;
    guess(i) = own(parameter(i)).value_or(value);
  }
  for (const NuisanceBlock& block : nuisances_) guess.segment(block.first, block.size()) = block.guess;
  return guess;
}

double Unknowns::value_of(FitParameter parameter, const Eigen::VectorXd& values) const {
  if (const auto i = find(parameter)) return values(*i);
  if (const auto it = problem_->fixed.find(parameter); it != problem_->fixed.end()) return it->second;
  return as_given(parameter);
}

std::optional<Prior> Unknowns::prior(Eigen::Index i) const {
  const FitParameter quantity = parameter(i);
  if (const auto it = problem_->prior.find(quantity); it != problem_->prior.end()) return it->second;
  if (i < reported()) return std::nullopt;
  double variance = 0;
  for (const Condition& condition : problem_->conditions)
    if (condition.quantity == quantity) variance += condition.sd * condition.sd;
  return Prior{as_given(quantity), std::sqrt(variance)};
}

AppliedScenario Unknowns::apply(const Eigen::VectorXd& values, const model::Scenario& base,
                                bool amplitude_from_track, bool derivatives) const {
  Setting run(*this, values, base, {}, derivatives ? shared_ : kNone);
  apply_shared(reference_, amplitude_from_track, run);
  return run.applied();
}

AppliedScenario Unknowns::apply_summary(const Eigen::VectorXd& values, const SummaryRun& data,
                                        const std::vector<Eigen::Index>& by) const {
  const bool follows = data.measured.given_as_velocity && is_known(FitParameter::angular_frequency);
  model::Scenario base = data.scenario;
  if (data.measured.duration > 0) base.duration = follows ? 0 : data.measured.duration;
  Setting run(*this, values, base, {}, by);
  apply_shared(reference_, data.amplitude_from_track, run);
  change_friction(base.friction.pulse_width - mean_width_, data.course, run);
  AppliedScenario result = run.applied();
  if (follows)
    result.stretch = result.scenario.drive.angular_frequency / data.scenario.drive.angular_frequency;
  return result;
}

AppliedScenario Unknowns::apply_trajectory(const Eigen::VectorXd& values, std::size_t index,
                                           bool derivatives) const {
  const TrajectoryRun& data = problem_->trajectory_runs[index];
  if (data.free_slide) return apply_free_slide(values, index, derivatives);
  Setting run(*this, values, data.scenario, own_[index], derivatives ? shared_ : kNone);
  apply_shared(reference_, data.amplitude_from_track, run);
  change_friction(data.scenario.friction.pulse_width - mean_width_, data.course, run);
  if (const NuisanceBlock* phase = find(Nuisance::phase, index))
    run.add(Parameter::start_phase, run.own(phase->first));
  if (const NuisanceBlock* own = find(Nuisance::own, index))
    for (Eigen::Index k = 0; k < own->size(); ++k)
      run.add(data.own.parameters[static_cast<std::size_t>(k)], run.own(own->first + k));
  return run.applied();
}

AppliedScenario Unknowns::apply_free_slide(const Eigen::VectorXd& values, std::size_t index,
                                           bool derivatives) const {
  const TrajectoryRun& slide = problem_->trajectory_runs[index];
  model::Scenario base = slide.scenario;
  base.drive.amplitude = base.drive.amplitude_y = 0;
  base.friction.pulse_width = 0;
  base.start = model::Start::rest;
  Setting run(*this, values, base, own_[index], derivatives ? shared_ : kNone);
  apply_shared(reference_, false, run);
  if (slide.slope != 0) lean(slide, run);
  // The platform rests: its frequency is only the clock of the model.
  run.set(Parameter::angular_frequency, run.constant(run.scenario.drive.angular_frequency));
  const Eigen::Index velocity = find(Nuisance::velocity, index)->first;
  run.set(Parameter::velocity_x, run.own(velocity));
  run.set(Parameter::velocity_y, run.own(velocity + 1));
  run.set(Parameter::viscous, run.of(FitParameter::viscous));
  if (const NuisanceBlock* deviation = find(Nuisance::deviation, index)) {
    run.add(Parameter::mu1, run.own(deviation->first));
    if (deviation->size() > 1) run.add(Parameter::viscous, run.own(deviation->first + 1));
  }
  if (const NuisanceBlock* spin = find(Nuisance::spin, index)) {
    // The radius was measured in the same picture. An even disc about its bearing face: k = (R/R_bearing)^2
    // / 2.
    Number logarithm = run.own(spin->first + 1);
    const double within = DiscSpin::within(logarithm.value(), slide.track.round);
    if (within != logarithm.value()) logarithm = run.constant(within);
    const Number bearing = exp(logarithm), radius = run.of(FitParameter::scale) * bearing;
    run.scenario.spin.radius = slide.track.radius * radius.value();
    // The path knows rate and radius by their product alone.
    run.set(Parameter::spin, run.own(spin->first) * radius / radius.value());
    run.set(Parameter::inertia, 0.5 / (bearing * bearing));
  }
  return run.applied();
}

long Unknowns::most_steps(const model::Scenario& scenario) const {
  constexpr double kAnyway = 10'000, kATurn = 1000;
  if (!(scenario.drive.amplitude > 0) && !(scenario.drive.amplitude_y > 0)) return 2 * std::lround(kAnyway);
  const double turns = scenario.end_time() * reference_frequency() / (2 * std::numbers::pi);
  const auto most = static_cast<double>(model::IntegrationOptions{}.max_steps);
  return std::lround(std::min(kAnyway + kATurn * turns, most));
}

std::optional<double> Unknowns::sliding_threshold() const {
  if (!(reference_.amplitude > 0)) return std::nullopt;
  return reference_.amplitude * reference_.angular_frequency * reference_.angular_frequency /
         reference_.gravity;
}

}  // namespace tribotrack::fit::internal

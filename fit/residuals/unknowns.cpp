#include "fit/residuals/unknowns.h"

#include <algorithm>
#include <cmath>

#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

/// Of the optimiser's axis, where that is not logarithmic.
double unit_of(FitParameter parameter, double w, double threshold) {
  if (parameter == FitParameter::mu2) return 0.05 * threshold;
  if (parameter == FitParameter::delay) return 1 / w;
  return facts(parameter).sort == Sort::tilt ? 0.01 : 1;
}

class Chain {
 public:
  explicit Chain(AppliedScenario& applied) : applied_(applied) {}
  void add(model::Parameter parameter, std::optional<Eigen::Index> unknown, double derivative) {
    if (!unknown || derivative == 0) return;
    auto& wanted = applied_.wanted;
    const auto place = std::find(wanted.begin(), wanted.end(), parameter);
    const auto row = place - wanted.begin();
    if (place == wanted.end()) {
      wanted.push_back(parameter);
      applied_.chain.conservativeResize(row + 1, Eigen::NoChange);
      applied_.chain.row(row).setZero();
    }
    applied_.chain(row, *unknown) += derivative;
  }
  /// What there is of a parameter, times a factor.
  void scale(model::Parameter parameter, double factor) {
    const auto place = std::ranges::find(applied_.wanted, parameter);
    if (place != applied_.wanted.end()) applied_.chain.row(place - applied_.wanted.begin()) *= factor;
  }

 private:
  AppliedScenario& applied_;
};

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
  AppliedScenario result;
  result.scenario = base;
  result.chain.resize(0, common());
  auto& drive = result.scenario.drive;
  auto& friction = result.scenario.friction;
  result.scale = value_of(FitParameter::scale, values);

  // Amplitude and frequency are those of the first driven run; the others keep their ratio to it.
  const double amplitude_factor =
      reference_.amplitude > 0 ? value_of(FitParameter::amplitude, values) / reference_.amplitude : 1;
  const double picture = amplitude_from_track ? result.scale : 1;
  const double ratio = value_of(FitParameter::amplitude_ratio, values);
  // Each takes a half of it: measured alike, mean and ratio are not correlated.
  const double along_x = 1 / std::sqrt(ratio), along_y = std::sqrt(ratio);
  drive.amplitude *= amplitude_factor * picture * along_x;
  drive.amplitude_y *= amplitude_factor * picture * along_y;
  const double frequency_ratio = base.drive.angular_frequency / reference_.angular_frequency;
  drive.angular_frequency = value_of(FitParameter::angular_frequency, values) * frequency_ratio;

  const double delay = value_of(FitParameter::delay, values);
  // Along an open profile mu goes to infinity: a part that rests does so at any greater one as well.
  constexpr double kRestsUnderAnyDrive = 1e9;
  friction.nominal = std::min(value_of(FitParameter::mu1, values), kRestsUnderAnyDrive);
  friction.reduced = std::min(value_of(FitParameter::mu2, values), kRestsUnderAnyDrive);
  friction.lag = value_of(FitParameter::lag, values) + drive.angular_frequency * delay +
                 value_of(FitParameter::phase_reference, values);
  drive.phase_shift += value_of(FitParameter::phase_shift, values);
  const bool from_rest = base.start == model::Start::rest && reference_.amplitude > 0;
  if (from_rest) result.scenario.start_phase += value_of(FitParameter::start_phase, values);
  const auto replace = [&](FitParameter parameter, double& given) {
    if (find(parameter) || problem_->fixed.count(parameter)) given = value_of(parameter, values);
  };
  replace(FitParameter::tilt_x, drive.tilt_x);
  replace(FitParameter::tilt_y, drive.tilt_y);
  replace(FitParameter::gravity, drive.gravity);
  if (!derivatives) return result;

  Chain chain(result);
  chain.add(model::Parameter::mu1, find(FitParameter::mu1), 1);
  if (friction.pulse_width > 0) {
    chain.add(model::Parameter::mu2, find(FitParameter::mu2), 1);
    chain.add(model::Parameter::lag, find(FitParameter::lag), 1);
    chain.add(model::Parameter::lag, find(FitParameter::phase_reference), 1);
    chain.add(model::Parameter::lag, find(FitParameter::delay), drive.angular_frequency);
    chain.add(model::Parameter::lag, find(FitParameter::angular_frequency), delay * frequency_ratio);
  }
  const auto by_amplitude = [&](model::Parameter parameter, double own) {
    if (reference_.amplitude > 0)
      chain.add(parameter, find(FitParameter::amplitude), own * picture / reference_.amplitude);
    if (amplitude_from_track) chain.add(parameter, find(FitParameter::scale), own * amplitude_factor);
  };
  by_amplitude(model::Parameter::amplitude, base.drive.amplitude * along_x);
  by_amplitude(model::Parameter::amplitude_y, base.drive.amplitude_y * along_y);
  const auto amplitudes = find(FitParameter::amplitude_ratio);
  chain.add(model::Parameter::amplitude, amplitudes, -0.5 * drive.amplitude / ratio);
  chain.add(model::Parameter::amplitude_y, amplitudes, 0.5 * drive.amplitude_y / ratio);
  if (base.drive.amplitude_y > 0)
    chain.add(model::Parameter::phase_shift, find(FitParameter::phase_shift), 1);
  if (from_rest) chain.add(model::Parameter::start_phase, find(FitParameter::start_phase), 1);
  chain.add(model::Parameter::gravity, find(FitParameter::gravity), 1);
  chain.add(model::Parameter::angular_frequency, find(FitParameter::angular_frequency), frequency_ratio);
  chain.add(model::Parameter::tilt_x, find(FitParameter::tilt_x), 1);
  chain.add(model::Parameter::tilt_y, find(FitParameter::tilt_y), 1);
  return result;
}

AppliedScenario Unknowns::apply_summary(const Eigen::VectorXd& values, const SummaryRun& run,
                                        bool derivatives) const {
  const bool follows =
      run.measured.given_as_velocity &&
      (find(FitParameter::angular_frequency) || problem_->fixed.count(FitParameter::angular_frequency));
  model::Scenario base = run.scenario;
  if (run.measured.duration > 0) base.duration = follows ? 0 : run.measured.duration;
  AppliedScenario result = apply(values, base, run.amplitude_from_track, derivatives);
  change_friction(values, run.course, derivatives, result);
  if (follows)
    result.stretch = result.scenario.drive.angular_frequency / run.scenario.drive.angular_frequency;
  return result;
}

void Unknowns::change_friction(const Eigen::VectorXd& values, double course, bool derivatives,
                               AppliedScenario& applied) const {
  const auto by_width = find(FitParameter::mu2_width), by_course = find(FitParameter::wear);
  if (!by_width && !by_course) return;
  model::Friction& friction = applied.scenario.friction;
  const double wider = friction.pulse_width - mean_width_;
  // Exponentials: friction is never negative.
  const double heated = std::exp(by_width ? wider * values(*by_width) : 0);
  const double worn = std::exp(by_course ? course * values(*by_course) : 0);
  const double mu1 = friction.nominal, mu2 = friction.reduced;
  friction.nominal = mu1 * worn;
  friction.reduced = mu2 * worn * heated;
  if (!derivatives) return;
  Chain chain(applied);
  chain.scale(model::Parameter::mu1, worn);
  chain.scale(model::Parameter::mu2, worn * heated);
  chain.add(model::Parameter::mu1, by_course, mu1 * worn * course);
  if (!(friction.pulse_width > 0)) return;
  chain.add(model::Parameter::mu2, by_course, friction.reduced * course);
  chain.add(model::Parameter::mu2, by_width, friction.reduced * wider);
}

void Unknowns::widen(std::size_t run, AppliedScenario& applied) const {
  const Eigen::Index own = own_[run].count;
  applied.chain.conservativeResize(Eigen::NoChange, common() + own);
  applied.chain.rightCols(own).setZero();
}

AppliedScenario Unknowns::apply_trajectory(const Eigen::VectorXd& values, std::size_t run,
                                           bool derivatives) const {
  const TrajectoryRun& data = problem_->trajectory_runs[run];
  if (data.free_slide) return apply_free_slide(values, run, derivatives);
  AppliedScenario result = apply(values, data.scenario, data.amplitude_from_track, derivatives);
  change_friction(values, data.course, derivatives, result);
  widen(run, result);
  Chain chain(result);
  const auto move = [&](model::Parameter parameter, Eigen::Index by) {
    result.scenario.set(parameter, result.scenario.get(parameter) + values(by));
    if (derivatives) chain.add(parameter, common() + by - own_[run].first, 1);
  };
  if (const NuisanceBlock* phase = find(Nuisance::phase, run))
    move(model::Parameter::start_phase, phase->first);
  if (const NuisanceBlock* own = find(Nuisance::own, run))
    for (Eigen::Index k = 0; k < own->size(); ++k)
      move(data.own.parameters[static_cast<std::size_t>(k)], own->first + k);
  return result;
}

void Unknowns::apply_slope(const Eigen::VectorXd& values, const TrajectoryRun& slide, bool derivatives,
                           AppliedScenario& applied) const {
  const double theta = std::abs(slide.slope) + value_of(FitParameter::slope, values);
  model::Drive& drive = applied.scenario.drive;
  const double gravity = drive.gravity;
  // A part on a plane tilted by theta moves as one on a level platform that is pressed with g cos(theta) and
  // pulled with g sin(theta) = g cos(theta) tan(theta) downhill.
  drive.gravity *= std::cos(theta);
  drive.tilt_x = std::asin(std::tan(theta) * slide.downhill.x());
  drive.tilt_y = std::asin(std::tan(theta) * slide.downhill.y());
  if (!derivatives) return;
  // The plane's own slope stands for the platform's tilt.
  Chain chain(applied);
  chain.scale(model::Parameter::gravity, std::cos(theta));
  chain.scale(model::Parameter::tilt_x, 0);
  chain.scale(model::Parameter::tilt_y, 0);
  const auto unknown = find(FitParameter::slope);
  const double steeper = 1 / (std::cos(theta) * std::cos(theta));  // d tan(theta) / d theta
  chain.add(model::Parameter::gravity, unknown, -gravity * std::sin(theta));
  chain.add(model::Parameter::tilt_x, unknown, steeper * slide.downhill.x() / std::cos(drive.tilt_x));
  chain.add(model::Parameter::tilt_y, unknown, steeper * slide.downhill.y() / std::cos(drive.tilt_y));
}

AppliedScenario Unknowns::apply_free_slide(const Eigen::VectorXd& values, std::size_t run,
                                           bool derivatives) const {
  const TrajectoryRun& slide = problem_->trajectory_runs[run];
  model::Scenario base = slide.scenario;
  base.drive.amplitude = base.drive.amplitude_y = 0;
  base.friction.pulse_width = 0;
  base.start = model::Start::rest;
  AppliedScenario result = apply(values, base, false, derivatives);
  if (slide.slope != 0) apply_slope(values, slide, derivatives, result);
  widen(run, result);
  const Eigen::Index v = find(Nuisance::velocity, run)->first, shared = common() - own_[run].first;
  const NuisanceBlock *spin = find(Nuisance::spin, run), *deviation = find(Nuisance::deviation, run);
  result.scenario.initial_velocity = values.segment<2>(v);
  result.scenario.viscous = value_of(FitParameter::viscous, values);
  const bool viscous_too = deviation && deviation->size() > 1;
  if (deviation) result.scenario.friction.nominal += values(deviation->first);
  if (viscous_too) result.scenario.viscous += values(deviation->first + 1);
  if (spin) {
    // The radius was measured in the same picture. An even disc about its bearing face: k = (R/R_bearing)^2
    // / 2.
    const double bearing = std::exp(DiscSpin::within(values(spin->first + 1), slide.track.round));
    result.scenario.spin = {values(spin->first), slide.track.radius * result.scale * bearing,
                            0.5 / (bearing * bearing)};
  }
  if (!derivatives) return result;
  Chain chain(result);
  chain.add(model::Parameter::viscous, find(FitParameter::viscous), 1);
  chain.add(model::Parameter::velocity_x, shared + v, 1);
  chain.add(model::Parameter::velocity_y, shared + v + 1, 1);
  if (deviation) chain.add(model::Parameter::mu1, shared + deviation->first, 1);
  if (viscous_too) chain.add(model::Parameter::viscous, shared + deviation->first + 1, 1);
  if (spin) {
    // The path knows rate and radius by their product alone.
    const Eigen::Index rate = shared + spin->first;
    chain.add(model::Parameter::spin, rate, 1);
    const double bearing = values(spin->first + 1),
                 inside = DiscSpin::within(bearing, slide.track.round) == bearing ? 1 : 0;
    chain.add(model::Parameter::spin, rate + 1, inside * values(spin->first));
    chain.add(model::Parameter::spin, find(FitParameter::scale), values(spin->first) / result.scale);
    chain.add(model::Parameter::inertia, rate + 1, -2 * inside * result.scenario.spin.inertia);
  }
  // The platform rests: its frequency is only the clock of the model.
  if (const auto w = find(FitParameter::angular_frequency)) result.chain.col(*w).setZero();
  return result;
}

std::optional<double> Unknowns::sliding_threshold() const {
  if (!(reference_.amplitude > 0)) return std::nullopt;
  return reference_.amplitude * reference_.angular_frequency * reference_.angular_frequency /
         reference_.gravity;
}

}  // namespace tribotrack::fit::internal

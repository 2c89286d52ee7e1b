#include "fit/conditions.h"

#include <algorithm>
#include <map>

#include "fit/conditions/quantities.h"
#include "fit/tools/angles.h"
#include "fit/tools/parameters.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit {

using model::Parameter;

namespace {

using internal::is_driven, internal::is_scaled, internal::mean_over;

constexpr std::string_view kAssumed = ", default sd";

/// What all runs share, listed in `errors` and `taken_as_exact`.
class SharedErrors {
 public:
  SharedErrors(std::span<const RunEvidence> runs, const SharedEvidence& shared, Conditions& conditions)
      : runs_(runs), shared_(shared), conditions_(conditions) {}

  /// `one`: A_y is A, not a quantity of its own.
  void amplitudes(bool one) {
    const PooledQuantity x = of(Source::amplitude), y = of(Source::amplitude_y);
    if (one) {
      add(FitParameter::amplitude, x.shared_sd, conditions_.from(x), x.known_beforehand);
      add(FitParameter::amplitude_ratio, shared_.amplitude_ratio_sd, not_given(Source::amplitude_y));
    } else {  // independent errors of both: of their mean and of their ratio, which do not go together
      const double both = std::hypot(x.shared_sd, y.shared_sd);
      const std::string from = conditions_.from(x.shared_sd > 0 ? x : y);
      add(FitParameter::amplitude, both / 2, from, x.known_beforehand || y.known_beforehand);
      add(FitParameter::amplitude_ratio, both, from);
    }
    // Driven runs whose A is given are free of it.
    double coder = 0, exposure = 0, driven = 0;
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      if (!runs_[k].driven) continue;
      ++driven;
      if (!conditions_.runs[k].amplitude_from_track) continue;
      coder += runs_[k].coder_attenuation;
      exposure += runs_[k].seen ? runs_[k].seen->exposure_doubt : 0;
    }
    if (driven > 0) {
      add(FitParameter::amplitude, coder / driven, kFromCoder);
      add(FitParameter::amplitude, exposure / driven, "exposure, not known");
    }
    exact_if(x.exact, Source::amplitude);
    exact_if(y.exact || (one && x.shared_sd > 0 && shared_.amplitude_ratio_sd == 0), Source::amplitude_y);
  }

  void frequency_and_phase_shift() {
    const PooledQuantity w = of(Source::angular_frequency), epsilon = of(Source::phase_shift);
    add(FitParameter::angular_frequency, w.shared_sd, conditions_.from(w), w.known_beforehand);
    add(FitParameter::phase_shift, epsilon.shared_sd, conditions_.from(epsilon));
    exact_if(w.exact, Source::angular_frequency);
    const bool by_default = any_driven() && conditions_.find(Source::phase_shift) == nullptr;
    if (by_default) add(FitParameter::phase_shift, shared_.phase_shift_sd, not_given(Source::phase_shift));
    exact_if(epsilon.exact || (by_default && shared_.phase_shift_sd == 0), Source::phase_shift);
  }

  /// All that is measured, w included, in seconds that are too long by a share: then g, the one quantity that
  /// is known in true seconds, is off by twice that. With w given in true seconds the displacement is read
  /// too late by that share.
  void clock() {
    const double sd = shared_.clock_sd.value_or(0);
    if (!any_driven() || of(Source::angular_frequency).by_measurement)
      add(FitParameter::gravity, 2 * sd, given_as(Source::frame_rate));
    else
      add(FitParameter::scale, sd, given_as(Source::frame_rate));
    exact_if(shared_.clock_sd && sd == 0, Source::frame_rate);
  }

  void gravity_and_tilt() {
    add_given(FitParameter::gravity, shared_.gravity_sd, Source::gravity);
    add_given(FitParameter::tilt_x, shared_.tilt_x_sd, Source::tilt_x);
    add_given(FitParameter::tilt_y, shared_.tilt_y_sd, Source::tilt_y);
    exact_if(shared_.gravity_sd == 0, Source::gravity);
    exact_if(shared_.tilt_x_sd == 0 && !fitted(FitParameter::tilt_x), Source::tilt_x);
    exact_if(shared_.tilt_y_sd == 0 && !fitted(FitParameter::tilt_y), Source::tilt_y);
  }

  /// One instrument measures the slopes of all inclines.
  void slope() {
    const auto inclined = [](const RunEvidence& run) { return run.slope.has_value(); };
    const double sd = mean_over(runs_, inclined, [](const RunEvidence& r) { return r.slope->sd; });
    add_given(FitParameter::slope, sd, Source::slope);
    exact_if(sd == 0 && std::ranges::any_of(runs_, inclined), Source::slope);
  }

  void scale() {
    const double all = mean_over(runs_, is_scaled, [](const RunEvidence& r) { return r.scale->relative_sd; });
    const bool by_diameter = std::ranges::any_of(
        runs_, [](const RunEvidence& r) { return r.scale && r.scale->by == Source::diameter; });
    if (by_diameter) {
      const double diameter = std::min(shared_.length_sd, all);
      add_given(FitParameter::scale, diameter, Source::diameter);
      add(FitParameter::scale, std::sqrt(all * all - diameter * diameter), "part's radius in the pictures",
          true);
      exact_if(diameter == 0, Source::diameter);
    } else {
      const Source by = shared_.scale;
      add(FitParameter::scale, all,
          by == Source::calibration ? "calibration"
          : by == Source::tag       ? "the tag's size, and its sides in the pictures"
                                    : given_as(by),
          !assumed(by));
      exact_if(by == Source::tag && shared_.length_sd == 0, Source::tag);
      exact_if(all == 0 && std::ranges::any_of(runs_, is_scaled), Source::scale);
    }
    const char* from = "height and working distance, campaign";
    if (!by_diameter) add(FitParameter::scale, shared_.parallax_sd, from);
    if (of(Source::amplitude).by_measurement) add(FitParameter::amplitude, shared_.parallax_sd, from);
  }

  void phase_reference() {
    add(FitParameter::phase_reference,
        mean_over(runs_, is_driven, [](const RunEvidence& r) { return r.coder_delay; }), kFromCoder);
    const auto by_sensor = [](const RunEvidence& r) { return r.driven && !(r.gate && r.gate_by_camera); };
    const auto from_sensor = std::ranges::count_if(runs_, by_sensor);
    const double sd = shared_.sensor_axis_sd;
    exact_if(from_sensor > 0 && sd == 0, Source::sensor_axis);
    if (from_sensor == std::ranges::count_if(runs_, is_driven)) {
      if (from_sensor > 0) add(FitParameter::phase_reference, sd, given_as(Source::sensor_axis));
    } else if (from_sensor == 0) {
      conditions_.sensor_axis_not_used = sd > 0;
    } else {
      for (std::size_t k = 0; k < runs_.size(); ++k)
        if (by_sensor(runs_[k])) conditions_.runs[k].own.add(Parameter::phi, sd * sd);
    }
  }

  /// Frames that meet every cycle at the same phases leave open where in a bracket an edge lies, and where
  /// the camera waits for the drive they do so in all runs alike. Then what lamps show differs from the
  /// commands by less than each of them knows itself, and what is missing of that variance is one error of
  /// all runs.
  void gate_brackets() {
    constexpr double kByChance = 0.05;
    std::vector<std::size_t> bracketed;
    std::vector<double> off;
    double own = 0;  // variance of the opening edges, which is in phi and, against it, in dtau
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      const RunEvidence& run = runs_[k];
      if (!run.driven || !run.gate || !run.gate_by_camera || !(run.gate->bracket > 0)) continue;
      bracketed.push_back(k);
      own -= run.gate->covariance;
      off.push_back(std::remainder(run.gate->phi.value - run.phi.value, internal::turn));
      off.back() = off.front() + std::remainder(off.back() - off.front(), internal::turn);
    }
    const double n = static_cast<double>(off.size());
    if (n < 2 || !(own > 0)) return;
    own /= n;
    double mean = 0, squares = 0;
    for (const double each : off) mean += each / n;
    for (const double each : off) squares += (each - mean) * (each - mean);
    if (1 - internal::chi2_survival(squares / own, n - 1) > kByChance) return;
    const double shared = own - squares / (n - 1);
    for (const std::size_t k : bracketed) {
      OwnErrors& errors = conditions_.runs[k].own;
      const double out = std::min(shared, -runs_[k].gate->covariance);
      const auto place = [&](Parameter p) {
        return std::ranges::find(errors.parameters, p) - errors.parameters.begin();
      };
      const auto phi = place(Parameter::phi), dtau = place(Parameter::dtau), all = errors.covariance.rows();
      if (phi == all) continue;
      errors.covariance(phi, phi) -= out;
      if (dtau < all) errors.add(Parameter::phi, Parameter::dtau, out);
    }
    add(FitParameter::phase_reference, std::sqrt(shared),
        "lamp, frames that meet the edges alike in all runs");
  }

  /// Of runs from rest the phase there: one of all, as one hand starts them, or each its own beside runs that
  /// tell it.
  void start() {
    const auto from_rest = [](const RunEvidence& r) { return r.driven && r.from_rest; };
    const auto unknown = [&](const RunEvidence& r) {
      return from_rest(r) && r.start_assumed && !r.start_phase && !r.phase_at_zero;
    };
    const auto count = std::ranges::count_if(runs_, unknown);
    const double sd = shared_.start_phase_sd;
    exact_if(count > 0 && sd == 0, Source::start_phase);
    if (count == std::ranges::count_if(runs_, from_rest)) {
      if (count > 0) add(FitParameter::start_phase, sd, not_given(Source::start_phase));
      return;
    }
    for (std::size_t k = 0; k < runs_.size(); ++k)
      if (unknown(runs_[k])) conditions_.runs[k].own.add(Parameter::start_phase, sd * sd);
  }

  void gates() {
    const auto taken_as_exact = [&](Estimate RunEvidence::*commanded) {
      return std::ranges::any_of(
          runs_, [&](const RunEvidence& r) { return r.driven && !r.gate && (r.*commanded).sd == 0; });
    };
    exact_if(taken_as_exact(&RunEvidence::phi), Source::phi);
    exact_if(taken_as_exact(&RunEvidence::dtau), Source::dtau);
  }

  /// What dry friction and actuators are known to do beside the paper's law: friction at low speeds is up to
  /// a fifth higher, rises by some 1 1/s with speed, mu2 by a tenth with the length of the pulse or the
  /// speed; edges last about 0.1 rad; parts and platforms wear.
  void friction_law() {
    constexpr std::pair<FitParameter, double> kDepartures[] = {
        {FitParameter::stribeck, 0.1},  {FitParameter::stribeck_speed, internal::kStribeckSpeed},
        {FitParameter::viscous, 1},     {FitParameter::gate_edges, 0.01},
        {FitParameter::mu2_width, 0.1}, {FitParameter::wear, 0.02}};
    exact_if(shared_.law_is_exact && any_driven(), Source::friction_law);
    if (shared_.law_is_exact || !any_driven()) return;
    // A ramp may begin at the edge that was meant, lie about it, or end there.
    constexpr double kHalfARamp = 0.05;
    add(FitParameter::phase_reference, kHalfARamp, to_string(Source::friction_law) + std::string(kAssumed));
    for (const auto& [law, sd] : kDepartures)
      add(law, sd, to_string(Source::friction_law) + std::string(kAssumed));
  }

 private:
  bool assumed(Source source) const { return std::ranges::count(shared_.assumed, source) > 0; }
  /// "gravity_m_s2_sd, campaign"
  std::string given_as(Source source) const {
    return to_string(source) + (assumed(source) ? std::string(kAssumed) : "_sd, campaign");
  }
  static std::string not_given(Source source) {
    return std::string(to_string(source)) + " not given" + std::string(kAssumed);
  }
  void add_given(FitParameter quantity, double sd, Source source) {
    add(quantity, sd, given_as(source), !assumed(source));
  }
  PooledQuantity of(Source source) const {
    const PooledQuantity* found = conditions_.find(source);
    return found != nullptr ? *found : PooledQuantity{};
  }
  bool any_driven() const { return std::ranges::any_of(runs_, is_driven); }
  bool fitted(FitParameter parameter) const { return std::ranges::count(shared_.fitted, parameter) > 0; }
  void add(FitParameter quantity, double sd, const std::string& from, bool known_beforehand = false) {
    if (sd > 0) conditions_.errors.push_back({quantity, sd, from, known_beforehand});
  }
  void exact_if(bool exact, Source source) {
    if (exact) conditions_.taken_as_exact.push_back(source);
  }

  std::span<const RunEvidence> runs_;
  const SharedEvidence& shared_;
  Conditions& conditions_;
};

/// A_y is A where neither is measured nor it is given: one error moves both.
bool one_amplitude(Conditions& conditions) {
  const PooledQuantity* y = conditions.find(Source::amplitude_y);
  if (y == nullptr || !y->implied || y->by_measurement) return false;
  for (RunConditions& run : conditions.runs) {
    const double sd = run.own.sd(Parameter::amplitude);
    if (sd > 0) run.own.add(Parameter::amplitude, Parameter::amplitude_y, sd * sd);
  }
  return true;
}

}  // namespace

const char* to_string(Source source) {
  constexpr const char* kNames[] = {"amplitude_mm",    "amplitude_y_mm",  "angular_frequency_rad_s",
                                    "phase_shift_rad", "gravity_m_s2",    "tilt_x_rad",
                                    "tilt_y_rad",      "slope_rad",       "phi_rad",
                                    "dtau_rad",        "xi_axis_rad",     "frame_rate_hz",
                                    "mm_per_px",       "calibration",     "diameter_mm",
                                    "tag_mm",          "start_phase_rad", "friction_law"};
  return kNames[static_cast<std::size_t>(source)];
}

bool is_assumed(std::string_view from) {
  return from.ends_with(kAssumed);
}

const PooledQuantity* Conditions::find(Source quantity) const {
  const auto found = std::ranges::find(quantities, quantity, &PooledQuantity::quantity);
  return found == quantities.end() ? nullptr : &*found;
}

std::string Conditions::from(const PooledQuantity& quantity) const {
  using From = PooledQuantity::From;
  const std::string seen =
      seen_by + ", " + std::to_string(quantity.runs) + (quantity.runs == 1 ? " run" : " runs");
  if (quantity.quantity == Source::diameter) return "campaign; lengths go by the given scale";
  switch (quantity.from) {
    case From::given_exactly:
      return "campaign, taken as exact";
    case From::given:
      return quantity.assumed ? "campaign" + std::string(kAssumed) : "campaign";
    case From::given_and_measured:
      return "campaign and " + seen;
    case From::measured:
      return seen;
    case From::each_its_own:
      return seen_by + ", each run its own";
  }
  return "";
}

Conditions pool(std::span<const RunEvidence> runs, const SharedEvidence& shared,
                std::vector<RunConditions> start) {
  Conditions conditions;
  conditions.seen_by = shared.seen_by;
  conditions.runs = std::move(start);
  internal::pool_quantities(runs, shared, conditions);
  SharedErrors errors(runs, shared, conditions);
  errors.amplitudes(one_amplitude(conditions));
  errors.frequency_and_phase_shift();
  errors.clock();
  errors.gravity_and_tilt();
  errors.slope();
  errors.scale();
  errors.phase_reference();
  errors.gate_brackets();
  errors.start();
  errors.gates();
  errors.friction_law();
  return conditions;
}

void put_into(Problem& problem, const Conditions& conditions) {
  const internal::Reference reference = internal::reference_of(problem);
  std::map<FitParameter, double> variance;
  for (const SharedError& error : conditions.errors) {
    const bool relative = internal::facts(error.quantity).sort == internal::Sort::positive;
    const double sd = error.sd * (relative ? reference.as_given(error.quantity) : 1);
    if (!problem.fits(error.quantity))
      problem.conditions.push_back({error.quantity, sd, error.from});
    else if (error.known_beforehand)
      variance[error.quantity] += sd * sd;
  }
  for (const auto& [quantity, sum] : variance)
    problem.prior.try_emplace(quantity, Prior{reference.as_given(quantity), std::sqrt(sum)});
  for (const Source source : conditions.taken_as_exact)
    if (source == Source::diameter || source == Source::scale || source == Source::tag)
      problem.exact.emplace_back(FitParameter::scale, to_string(source));
}

}  // namespace tribotrack::fit

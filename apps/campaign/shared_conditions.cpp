#include "apps/campaign/shared_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "apps/campaign/own_errors.h"
#include "apps/campaign/shared_errors.h"
#include "apps/measuring/condition_table.h"
#include "apps/program/errors.h"
#include "apps/text/number_text.h"
#include "fit/pooling.h"

namespace tribotrack::apps {

using fit::Estimate;
using model::Parameter;

namespace {

constexpr double kWarnedBeyond = 3;  ///< sd

struct Given {
  Estimate value;       ///< sd 0: exact
  bool of_run = false;  ///< its error is this run's own
};

/// One of the four quantities that a marker shows and a campaign may give.
struct Quantity {
  const char* key;
  Parameter parameter;
  double unit;         ///< SI
  bool angle = false;  ///< compared by differences, else by ratios
  std::function<Estimate(const fit::PlatformMotion&)> seen;
  std::function<std::optional<Given>(const PlatformSection&, const CampaignRun&)> given;
  std::function<double&(model::Drive&)> in;
};

std::optional<Given> given_value(const std::optional<double>& run, const std::optional<double>& run_sd,
                                 const std::optional<double>& platform,
                                 const std::optional<double>& platform_sd) {
  if (run) return Given{{*run, run_sd.value_or(0)}, true};
  if (platform) return Given{{*platform, platform_sd.value_or(0)}, false};
  return std::nullopt;
}

std::optional<Given> given_amplitude(const PlatformSection& p, const CampaignRun& r) {
  return given_value(r.amplitude, r.amplitude_sd, p.amplitude, p.amplitude_sd);
}

std::vector<Quantity> quantities() {
  using Motion = fit::PlatformMotion;
  using Section = PlatformSection;
  return {
      {"amplitude_mm", Parameter::amplitude, 1e-3, false, [](const Motion& m) { return m.amplitude; },
       given_amplitude, [](model::Drive& d) -> double& { return d.amplitude; }},
      {"amplitude_y_mm", Parameter::amplitude_y, 1e-3, false, [](const Motion& m) { return m.amplitude_y; },
       [](const Section& p, const CampaignRun& r) {
         return p.amplitude_y ? given_value({}, {}, p.amplitude_y, p.amplitude_y_sd) : given_amplitude(p, r);
       },
       [](model::Drive& d) -> double& { return d.amplitude_y; }},
      {"angular_frequency_rad_s", Parameter::angular_frequency, 1, false,
       [](const Motion& m) { return m.angular_frequency; },
       [](const Section& p, const CampaignRun& r) {
         return given_value(r.angular_frequency, r.angular_frequency_sd, p.angular_frequency,
                            p.angular_frequency_sd);
       },
       [](model::Drive& d) -> double& { return d.angular_frequency; }},
      {"phase_shift_rad", Parameter::phase_shift, 1, true, [](const Motion& m) { return m.phase_shift; },
       [](const Section& p, const CampaignRun&) {
         return given_value({}, {}, p.phase_shift, p.phase_shift_sd);
       },
       [](model::Drive& d) -> double& { return d.phase_shift; }},
  };
}

/// A driven run with what is given and seen of the quantity.
struct Entry {
  Run* run;
  std::optional<Given> given;
  std::optional<Estimate> seen;  ///< sd: of this run alone
};

double square(double x) {
  return x * x;
}

/// One quantity in all runs.
class Sharing {
 public:
  Sharing(const Campaign& campaign, const Quantity& quantity, std::vector<Run>& runs)
      : campaign_(campaign), quantity_(quantity), common_(common_error(campaign, runs, quantity.parameter)) {
    for (Run& run : runs) {
      if (!run.takes_part() || run.given.free_slide) continue;
      Entry entry{&run, quantity.given(campaign.platform, run.given), std::nullopt};
      if (run.measurement && run.measurement->platform) {
        if (seen_by_.empty()) seen_by_ = run.measurement->phase_source;
        const Estimate seen = quantity.seen(*run.measurement->platform);
        entry.seen = Estimate{seen.value, own_sd(campaign, runs, run, quantity.parameter, seen)};
      }
      entries_.push_back(entry);
    }
  }

  bool concerns_any() const {
    return std::any_of(entries_.begin(), entries_.end(), [](const Entry& e) { return e.given || e.seen; });
  }

  /// Throws for a slip.
  /// `in_all_only`: of the whole campaign, not of single runs.
  void refuse_slips(bool in_all_only = false) const;
  /// Fills everything; throws for a slip.
  SharedQuantity settle(SharedConditions& shared);

 private:
  enum class Group { platform, run, none };  ///< whose value a run is given

  static Group group_of(const Entry& entry) {
    return !entry.given ? Group::none : entry.given->of_run ? Group::run : Group::platform;
  }
  bool is_zero(const Entry& entry) const { return !quantity_.angle && entry.given->value.value == 0; }

  /// Measured over given, or measured less given of an angle; `with_given`: with the error of what is given.
  Estimate against_given(const Entry& e, bool with_given) const {
    const double given = e.given->value.value, sd = with_given ? e.given->value.sd : 0;
    if (quantity_.angle)
      return {std::remainder(e.seen->value - given, 2 * std::numbers::pi), std::hypot(e.seen->sd, sd)};
    return {e.seen->value / given, std::hypot(e.seen->sd, sd) / given};
  }
  double exactly_as_given() const { return quantity_.angle ? 0 : 1; }
  double applied(const Entry& e, double to_given) const {
    return quantity_.angle ? e.given->value.value + to_given : e.given->value.value * to_given;
  }
  /// Relative sd to that of the quantity, or the other way: an angle's is absolute.
  double relative(double sd, double value) const {
    return quantity_.angle || value == 0 ? sd : sd / std::abs(value);
  }

  std::string wrong_scale(const CampaignRun& run, double factor) const;
  [[noreturn]] void refuse(const Entry& entry, const Estimate& seen, std::size_t runs) const;
  void compare(SharedConditions& shared);
  void use_given(SharedQuantity& result);
  void use_measured(SharedConditions& shared, SharedQuantity& result);
  std::string seen_in(std::size_t runs) const {
    return fmt::format("{}, {} run{}", seen_by_, runs, runs == 1 ? "" : "s");
  }

  const Campaign& campaign_;
  const Quantity& quantity_;
  double common_;  ///< of what is measured, in all runs alike: relative, or an angle
  std::vector<Entry> entries_;
  std::string seen_by_;
  std::optional<fit::Pooled> to_given_;  ///< over the runs that are given and show it
  std::optional<fit::Pooled> measured_;  ///< over the runs that show it and are given none
  ConditionRow row_;
};

void Sharing::refuse(const Entry& entry, const Estimate& seen, std::size_t runs) const {
  const double given = entry.given->value.value / quantity_.unit, measured = seen.value / quantity_.unit;
  const std::string slip = likely_slip(quantity_.key, given, measured);
  const bool implied = quantity_.parameter == Parameter::amplitude_y && !campaign_.platform.amplitude_y;
  std::string where = entry.given->of_run || runs == 1 ? entry.run->given.place : campaign_.file.string();
  if (runs == 1) where += fmt::format(": run \"{}\"", entry.run->given.name);
  const std::string cause = quantity_.parameter == Parameter::angular_frequency
                                ? "; or frame_rate_hz is wrong"
                            : quantity_.angle ? ""
                                              : wrong_scale(entry.run->given, given / measured);
  throw InvalidInput(fmt::format(
      "{}: {} = {:.6g}{}, but the {} shows {}{}{}; mend it, or leave it out to use what was "
      "measured",
      where, quantity_.key, given, implied ? " (amplitude_mm, as it is not given)" : "", seen_by_,
      quoted(measured, seen.sd / quantity_.unit), runs > 1 ? fmt::format(" in {} runs", runs) : "",
      ": " + (slip.empty() ? "more than an error of measuring" : slip) +
          (slip.empty() || !quantity_.angle ? cause : "")));
}

/// What gives the scale may be wrong instead, by the inverse factor where it is a diameter.
std::string Sharing::wrong_scale(const CampaignRun& run, double factor) const {
  std::string scale = "calibration", slip;
  if (run.mm_per_px || campaign_.camera.mm_per_px) {
    scale = fmt::format("mm_per_px = {:.4g}", run.mm_per_px ? *run.mm_per_px : *campaign_.camera.mm_per_px);
  } else if (!campaign_.camera.calibration && campaign_.part.diameter_mm) {
    const double diameter = *campaign_.part.diameter_mm;
    scale = fmt::format("diameter_mm = {:.4g}", diameter);
    slip = likely_slip("diameter_mm", diameter, diameter * factor);
  }
  return fmt::format("; or {}, by which it was measured, is wrong{}{}", scale, slip.empty() ? "" : ": ",
                     slip);
}

void Sharing::refuse_slips(bool in_all_only) const {
  std::vector<const Entry*> off;
  std::size_t compared = 0;
  for (const Entry& e : entries_) {
    if (!e.given || !e.seen) continue;
    ++compared;
    double share = 0, sd = 0;
    if (is_zero(e)) {  // a platform said to rest, or to move along one axis
      const fit::PlatformMotion& motion = *e.run->measurement->platform;
      const double size = std::max(motion.amplitude.value, motion.amplitude_y.value);
      share = e.seen->value / size;
      sd = e.seen->sd / size;
    } else {
      const Estimate ratio = against_given(e, true);
      share = (ratio.value - exactly_as_given()) / (quantity_.angle ? std::numbers::pi / 2 : 1);
      sd = std::hypot(ratio.sd, common_);
    }
    if (std::abs(share) > kSlipShare && std::abs(share) > kWarnedBeyond * sd) off.push_back(&e);
  }
  if (off.empty() || (in_all_only && off.size() < compared)) return;
  // A slip in [platform] shows in all runs, one in a run in that run.
  refuse(*off.front(), *off.front()->seen, off.size() == compared ? compared : 1);
}

void Sharing::compare(SharedConditions& shared) {
  std::vector<Estimate> ratios, values;
  for (const Entry& e : entries_) {
    if (!e.seen) continue;
    if (!e.given)
      values.push_back(*e.seen);
    else if (!is_zero(e))
      ratios.push_back(against_given(e, e.given->of_run));
  }
  const auto pool = [&](const std::vector<Estimate>& list) {
    return quantity_.angle ? fit::pool_angles(list) : fit::pool(list);
  };
  if (!ratios.empty()) to_given_ = pool(ratios);
  if (!values.empty()) measured_ = pool(values);

  row_.quantity = quantity_.key;
  const auto first_given =
      std::find_if(entries_.begin(), entries_.end(), [](const Entry& e) { return e.given; });
  const auto in_unit = [&](Estimate e) { return Estimate{e.value / quantity_.unit, e.sd / quantity_.unit}; };
  if (first_given != entries_.end()) row_.given = in_unit(first_given->given->value);
  if (to_given_) {
    const double value = applied(*first_given, to_given_->mean.value);
    const double size = quantity_.angle ? 1 : std::abs(first_given->given->value.value);
    const double all =
        std::hypot(to_given_->mean.sd, common_ * (quantity_.angle ? 1 : to_given_->mean.value));
    row_.measured = in_unit({value, all * size});
    row_.runs = to_given_->count;
    row_.p_value = to_given_->p_value;
    const bool counted_already = first_given->given->of_run;
    const double of_given =
        counted_already ? 0 : relative(first_given->given->value.sd, first_given->given->value.value);
    row_.difference_in_sd = (to_given_->mean.value - exactly_as_given()) / std::hypot(all, of_given);
  } else if (measured_) {
    row_.measured =
        in_unit({measured_->mean.value,
                 std::hypot(measured_->own_sd, common_ * (quantity_.angle ? 1 : measured_->mean.value))});
    row_.runs = measured_->count;
    row_.p_value = measured_->p_value;
  }
  const bool implied = quantity_.parameter == Parameter::amplitude_y && !campaign_.platform.amplitude_y;
  const auto warned = [](const ConditionRow& row) {
    return row.difference_in_sd && std::abs(*row.difference_in_sd) > kWarnedBeyond;
  };
  const bool said_of_x = implied && !shared.table.empty() && warned(shared.table.back());
  if (warned(row_) && !said_of_x) {
    const bool exact = !(row_.given->sd > 0);
    shared.warnings.push_back(fmt::format(
        "{}: the campaign gives {}{}, the {} shows {} in {} run{}, {:.1f} sd off: {}", quantity_.key,
        exact ? fmt::format("{:.6g}", row_.given->value) : quoted(row_.given->value, row_.given->sd),
        implied ? " (amplitude_mm, as it is not given)" : "", seen_by_,
        quoted(row_.measured->value, row_.measured->sd), row_.runs, row_.runs == 1 ? "" : "s",
        std::abs(*row_.difference_in_sd),
        exact ? "the given value is used; leave it out to use the measured one, or give its sd"
              : "the mean of both is used, weighted by 1/sd^2; one of the sds is too small"));
  }
}

/// Runs that are given a value: it, or its mean with the measured one.
void Sharing::use_given(SharedQuantity& result) {
  const bool all_alike = std::all_of(entries_.begin(), entries_.end(),
                                     [](const Entry& e) { return group_of(e) == Group::platform; });
  for (Entry& e : entries_) {
    if (!e.given) continue;
    const double given_sd = relative(e.given->value.sd, e.given->value.value);
    const Estimate given{exactly_as_given(), given_sd};
    Estimate used = given;
    double share = 0;  // of the measured value
    if (given_sd > 0 && to_given_) {
      const Estimate measured{to_given_->mean.value, std::hypot(to_given_->own_sd, common_)};
      used = fit::combined(given, measured);
      share = square(used.sd / measured.sd);
    }
    const double value = applied(e, used.value);
    quantity_.in(e.run->scenario.drive) = value;
    const bool mostly_measured = share > 0.5;
    // What is common to all that is measured stands beside as errors of their own.
    const double sd =
        mostly_measured ? std::hypot((1 - share) * given_sd, share * to_given_->own_sd) : used.sd;
    if (e.given->of_run || !all_alike) {
      add_error(e.run->own, quantity_.parameter, square(quantity_.angle ? sd : sd * value));
      result.own = result.own || sd > 0;
    } else {
      result.shared_sd = sd;
      result.given_with_sd = given_sd > 0;
    }
    if (mostly_measured) result.measured = true;
    if (quantity_.parameter == Parameter::amplitude) e.run->amplitude_from_track = mostly_measured;
    if (row_.from.empty()) {
      row_.used = {value / quantity_.unit, (quantity_.angle ? used.sd : used.sd * value) / quantity_.unit};
      row_.from = result.from = !(given_sd > 0) ? "campaign, taken as exact"
                                : share > 0     ? fmt::format("campaign and {}", seen_in(to_given_->count))
                                                : "campaign";
    }
    result.exact = result.exact || !(given_sd > 0);
  }
}

/// Runs that are given none: the mean of all that show it, or each its own.
void Sharing::use_measured(SharedConditions& shared, SharedQuantity& result) {
  if (!measured_) return;
  const bool one = measured_->one_value();
  double low = INFINITY, high = -INFINITY;
  const bool all_alike =
      std::none_of(entries_.begin(), entries_.end(), [](const Entry& e) { return e.given; });
  for (Entry& e : entries_) {
    if (e.given || !e.seen) continue;
    const double value = one ? measured_->mean.value : e.seen->value;
    quantity_.in(e.run->scenario.drive) = value;
    low = std::min(low, e.seen->value / quantity_.unit);
    high = std::max(high, e.seen->value / quantity_.unit);
    if (one && all_alike) continue;
    const double sd = one ? measured_->own_sd : e.seen->sd;
    add_error(e.run->own, quantity_.parameter, sd * sd);
    if (!one && quantity_.parameter == Parameter::angular_frequency)  // the phase at the start went with it
      add_error(e.run->own, Parameter::angular_frequency, Parameter::start_phase,
                (e.run->measurement->start_time - e.run->measurement->platform->middle_time) * sd * sd);
    result.own = true;
  }
  result.measured = true;
  if (one && all_alike) result.shared_sd = relative(measured_->own_sd, measured_->mean.value);
  const std::string from = one ? seen_in(measured_->count) : fmt::format("{}, each run its own", seen_by_);
  if (row_.from.empty()) {
    row_.used = *row_.measured;
    row_.from = result.from = from;
  }
  if (!one)
    shared.warnings.push_back(fmt::format(
        "{} is not one quantity in all runs: {:.7g} to {:.7g} in {}, chi2 {:.3g} at {} degrees of freedom "
        "(p = {:.1g}): each run keeps what it shows itself; does the drive hold it?",
        quantity_.key, low, high, seen_in(measured_->count), measured_->chi2, measured_->count - 1,
        measured_->p_value));
}

SharedQuantity Sharing::settle(SharedConditions& shared) {
  SharedQuantity result;
  refuse_slips();
  compare(shared);
  use_given(result);
  use_measured(shared, result);
  if (row_.given || row_.measured) shared.table.push_back(row_);
  return result;
}

/// A diameter given beside another scale checks that scale. A rim that is rounded or lit from one side shows
/// another radius: only a slip is refused.
void compare_diameter(const Campaign& campaign, const std::vector<Run>& runs, SharedConditions& shared) {
  if (!campaign.part.diameter_mm) return;
  double sum = 0, relative_variance = 0;
  std::size_t count = 0;
  for (const Run& run : runs) {
    if (!run.takes_part() || !run.track || !run.track->mm_per_px) continue;
    const Track& track = *run.track;
    if (!(track.disc_radius_px > 0) || track.scale_source == kScaledByDiameter) continue;
    sum += 2 * track.disc_radius_px * *track.mm_per_px;
    relative_variance += square(track.mm_per_px_sd.value_or(0) / *track.mm_per_px) +
                         square(track.disc_radius_common_sd_px / track.disc_radius_px);
    ++count;
  }
  if (count == 0) return;
  const double n = static_cast<double>(count), given = *campaign.part.diameter_mm, measured = sum / n;
  if (std::abs(measured / given - 1) > kSlipShare) {
    const std::string slip = likely_slip("diameter_mm", given, measured);
    throw InvalidInput(fmt::format(
        "{}: [part] diameter_mm = {:.6g}, but the part measures {:.4g} mm by the scale that is given: {}; "
        "mend "
        "diameter_mm, mm_per_px or calibration",
        campaign.file.string(), given, measured, slip.empty() ? "more than an error of measuring" : slip));
  }
  ConditionRow row;
  row.quantity = "diameter_mm";
  row.given = Estimate{given, campaign.part.diameter_sd_mm};
  row.measured = Estimate{measured, measured * std::sqrt(relative_variance / n)};
  row.runs = count;
  row.used = *row.given;
  row.from = "campaign; lengths go by the given scale";
  shared.table.push_back(row);
}

/// Over whole cycles of the w that is used. Its error moves the model, not the data; only in the camera's
/// frame does it also leave some of the platform's own motion in them.
void measure_displacement_again(Run& analysed, double relative_w_sd) {
  if (!analysed.takes_part() || analysed.given.free_slide) return;
  const double w = analysed.scenario.drive.angular_frequency;
  const CampaignRun& run = analysed.given;
  try {
    if (analysed.track) {
      const double sd = std::hypot(relative_w_sd * w, sd_of(analysed.own, Parameter::angular_frequency));
      const bool camera_frame = !analysed.track->table.platform_frame;
      analysed.displacement =
          fit::measure_displacement(analysed.track->table, {w, camera_frame ? sd : 0}, run.cycles);
      analysed.scenario.cycles = analysed.displacement.cycles;
    } else {
      analysed.displacement =
          fit::displacement_from_alpha_v({*run.alpha, *run.alpha_sd}, {*run.v, *run.v_sd}, w, run.cycles);
    }
  } catch (const std::exception& error) {
    analysed.failure = failure_of(run, error);
  }
}

}  // namespace

void require_no_slips(const Campaign& campaign, std::vector<Run>& runs) {
  for (const Quantity& quantity : quantities())
    if (const Sharing sharing(campaign, quantity, runs); sharing.concerns_any()) sharing.refuse_slips(true);
}

SharedConditions share_conditions(const Campaign& campaign, std::vector<Run>& runs) {
  SharedConditions shared;
  std::map<Parameter, SharedQuantity> found;
  const std::vector<Quantity> all = quantities();
  for (const Quantity& quantity : all)
    if (Sharing sharing(campaign, quantity, runs); sharing.concerns_any())
      found[quantity.parameter] = sharing.settle(shared);
  // A_y is A where neither is measured nor it is given: one error moves both.
  const auto y = found.find(Parameter::amplitude_y);
  const bool implied = y != found.end() && !campaign.platform.amplitude_y && !y->second.measured;
  if (implied)
    for (Run& run : runs) {
      const double sd = sd_of(run.own, Parameter::amplitude);
      if (sd > 0) add_error(run.own, Parameter::amplitude, Parameter::amplitude_y, sd * sd);
    }
  compare_diameter(campaign, runs, shared);
  add_errors(campaign, runs, found, implied, shared);
  const auto w = found.find(Parameter::angular_frequency);
  for (Run& run : runs) measure_displacement_again(run, w == found.end() ? 0 : w->second.shared_sd);
  return shared;
}

void add_to(Json& fit, const SharedConditions& shared) {
  fit["conditions"] = conditions_json(shared.table);
  fit["taken_as_exact"] = shared.taken_as_exact;
  for (const std::string& warning : shared.warnings) fit["warnings"].push_back(warning);
}

}  // namespace tribotrack::apps

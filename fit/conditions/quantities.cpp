#include "fit/conditions/quantities.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/pooling.h"
#include "fit/tools/angles.h"

namespace tribotrack::fit::internal {

using model::Parameter;
using From = PooledQuantity::From;

namespace {

enum class Kind { length, frequency, angle };

/// Where one of the four stands.
struct Place {
  Source source;
  Parameter parameter;
  Kind kind;
  std::optional<GivenValue> RunEvidence::*given;
  Estimate PlatformMotion::*seen;
  double model::Drive::*in;
};

constexpr std::array<Place, 4> kPlaces = {{
    {Source::amplitude, Parameter::amplitude, Kind::length, &RunEvidence::amplitude,
     &PlatformMotion::amplitude, &model::Drive::amplitude},
    {Source::amplitude_y, Parameter::amplitude_y, Kind::length, &RunEvidence::amplitude_y,
     &PlatformMotion::amplitude_y, &model::Drive::amplitude_y},
    {Source::angular_frequency, Parameter::angular_frequency, Kind::frequency,
     &RunEvidence::angular_frequency, &PlatformMotion::angular_frequency, &model::Drive::angular_frequency},
    {Source::phase_shift, Parameter::phase_shift, Kind::angle, &RunEvidence::phase_shift,
     &PlatformMotion::phase_shift, &model::Drive::phase_shift},
}};

double square(double x) {
  return x * x;
}

bool one_scale(std::span<const RunEvidence> runs) {
  const auto first = std::ranges::find_if(runs, is_scaled);
  return std::ranges::all_of(
      runs, [&](const RunEvidence& r) { return !r.scale || r.scale->mm_per_px == first->scale->mm_per_px; });
}

bool in_picture(const SeenScale& scale) {
  return scale.by == Source::diameter || scale.by == Source::tag;
}

/// u_c, of what the marks show of lengths.
double common_of_lengths(std::span<const RunEvidence> runs, const SharedEvidence& shared) {
  const bool one = one_scale(runs);
  const double scale = mean_over(runs, is_scaled, [&](const RunEvidence& run) {
    const double all = run.scale->relative_sd;
    return !one && in_picture(*run.scale) ? std::min(shared.length_sd, all) : all;
  });
  const double coder =
      mean_over(runs, is_driven, [](const RunEvidence& run) { return run.coder_attenuation; });
  const double exposure = mean_over(
      runs, is_driven, [](const RunEvidence& run) { return run.seen ? run.seen->exposure_doubt : 0; });
  return std::hypot(std::hypot(coder, exposure), scale, shared.parallax_sd);
}

/// s_k m_k of a length.
double own_of_length(const RunEvidence& run, const Estimate& seen, bool own_scales, double length_sd) {
  const double common = std::hypot(run.coder_attenuation, run.seen->exposure_doubt) * seen.value;
  double variance = std::max(0.0, square(seen.sd) - square(common));
  if (own_scales && run.scale && in_picture(*run.scale)) {
    const double all = run.scale->relative_sd, common_length = std::min(length_sd, all);
    variance += (square(all) - square(common_length)) * square(seen.value);
  }
  return std::sqrt(variance);
}

/// A driven run with what is given and seen of the quantity.
struct Entry {
  std::size_t run = 0;
  std::optional<GivenValue> given;
  std::optional<Estimate> seen;  ///< sd: of this run alone
  double reference = 0;          ///< what is given; where nothing is, the mean of all that are given nothing
};

/// One of the four in all runs.
class Quantity {
 public:
  Quantity(const Place& place, std::span<const RunEvidence> runs, const SharedEvidence& shared)
      : place_(place), runs_(runs) {
    const bool own_scales = !one_scale(runs);
    if (place.kind == Kind::length) common_ = common_of_lengths(runs, shared);
    if (place.kind == Kind::frequency) common_ = shared.clock_sd.value_or(0);
    const auto assumed = [&](Source source) { return std::ranges::count(shared.assumed, source) > 0; };
    result_.quantity = place.source;
    result_.implied =
        place.source == Source::amplitude_y &&
        std::ranges::none_of(runs, [](const RunEvidence& r) { return r.amplitude_y.has_value(); });
    if (result_.implied) implied_sd_ = shared.amplitude_ratio_sd;
    result_.assumed = assumed(result_.implied ? Source::amplitude : place.source);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      if (!runs[k].driven) continue;
      Entry entry{k, result_.implied ? runs[k].amplitude : runs[k].*place.given, std::nullopt};
      if (runs[k].seen) {
        entry.seen = (*runs[k].seen).*place.seen;
        if (place.kind == Kind::length)
          entry.seen->sd = own_of_length(runs[k], *entry.seen, own_scales, shared.length_sd);
      }
      all_given_ = all_given_ && entry.given && !entry.given->of_run;
      none_given_ = none_given_ && !entry.given;
      if (entry.given) entry.reference = entry.given->value.value;
      if (entry.given || entry.seen) entries_.push_back(entry);
    }
  }

  bool concerns_any() const { return !entries_.empty(); }
  std::optional<Slip> slip() const;
  /// With what it means for each run.
  PooledQuantity settled(std::vector<RunConditions>& runs) {
    compare();
    for (const Entry& entry : entries_) use(entry, runs[entry.run]);
    return result_;
  }

 private:
  bool is_angle() const { return place_.kind == Kind::angle; }

  // x, in proportion to the reference.
  double neutral() const { return is_angle() ? 0 : 1; }
  /// Its sd: with that of what is given where that is the run's own.
  Estimate proportion(const Entry& e, bool with_given) const {
    const double sd = std::hypot(e.seen->sd, with_given ? e.given->value.sd : 0);
    if (is_angle()) return {std::remainder(e.seen->value - e.reference, turn), sd};
    return {e.seen->value / e.reference, sd / e.reference};
  }
  double applied(const Entry& e, double x) const { return is_angle() ? e.reference + x : e.reference * x; }
  double relative(double sd, double value) const {
    return is_angle() || value == 0 ? sd : sd / std::abs(value);
  }
  double absolute(double sd, double value) const { return is_angle() ? sd : sd * std::abs(value); }

  std::optional<Pooled> pooled(const std::vector<Estimate>& list) const {
    if (list.empty()) return std::nullopt;
    return is_angle() ? pool_angles(list) : pool(list);
  }
  void compare();
  void use(const Entry& entry, RunConditions& run);

  const Place& place_;
  std::span<const RunEvidence> runs_;
  double common_ = 0;      ///< u_c
  double implied_sd_ = 0;  ///< relative, of A_y taken to be A
  std::vector<Entry> entries_;
  const Entry* first_ = nullptr;               ///< that is given, else that shows it
  bool all_given_ = true, none_given_ = true;  ///< for all runs; for no run
  std::optional<Pooled> to_given_;             ///< x, over the runs that are given and show it
  std::optional<Pooled> alone_;                ///< x, over the runs that show it and are given none
  PooledQuantity result_;
};

std::optional<Slip> Quantity::slip() const {
  std::vector<const Entry*> off;
  std::size_t compared = 0;
  for (const Entry& e : entries_) {
    if (!e.given || !e.seen) continue;
    ++compared;
    Estimate share;
    if (e.reference == 0 && !is_angle()) {  // a platform said to rest, or to move along one axis
      const PlatformMotion& motion = *runs_[e.run].seen;
      const double size = std::max(motion.amplitude.value, motion.amplitude_y.value);
      share = {e.seen->value / size, e.seen->sd / size};
    } else {
      const Estimate x = proportion(e, true);
      share = {(x.value - neutral()) / (is_angle() ? pi / 2 : 1), std::hypot(x.sd, common_)};
    }
    if (std::abs(share.value) > std::max(kSlipShare, kContradictsBeyond * share.sd)) off.push_back(&e);
  }
  if (off.empty()) return std::nullopt;
  // One in what is given of all shows in all runs, one of a run in that run.
  const bool everywhere = off.size() == compared;
  const Entry& e = *off.front();
  return Slip{place_.source, e.run, *e.given, *e.seen, everywhere ? compared : 1, everywhere};
}

void Quantity::compare() {
  std::vector<Estimate> proportions, values;
  for (const Entry& e : entries_) {
    if (e.given && e.seen && (e.reference != 0 || is_angle()))
      proportions.push_back(proportion(e, e.given->of_run));
    if (!e.given) values.push_back(*e.seen);
  }
  to_given_ = pooled(proportions);
  if ((alone_ = pooled(values))) {
    const double mean = alone_->mean.value;
    for (Entry& e : entries_)
      if (!e.given) e.reference = mean;
    alone_->mean = {neutral(), relative(alone_->mean.sd, mean)};
    if (!alone_->one_value()) {
      const auto [low, high] = std::ranges::minmax(values, {}, &Estimate::value);
      result_.scatter = {low.value, high.value, alone_->chi2, alone_->p_value, alone_->count};
    }
  }

  const auto given = std::ranges::find_if(entries_, [](const Entry& e) { return e.given.has_value(); });
  first_ = given != entries_.end() ? &*given : &entries_.front();
  if (first_->given) result_.given = first_->given->value;
  const auto& seen = to_given_ ? to_given_ : alone_;
  if (!seen) return;
  const Entry& of =
      to_given_ ? *first_ : *std::ranges::find_if(entries_, [](const Entry& e) { return !e.given; });
  const Estimate x{seen->mean.value, std::hypot(seen->mean.sd, absolute(common_, seen->mean.value))};
  result_.measured = {applied(of, x.value), absolute(x.sd, of.reference)};
  result_.runs = seen->count;
  result_.p_value = seen->p_value;
  if (!to_given_) return;
  const double of_given =  // counted already, where it is each run's own
      first_->given->of_run ? 0 : relative(result_.given->sd, result_.given->value);
  result_.difference_in_sd = (x.value - neutral()) / std::hypot(x.sd, of_given, implied_sd_);
}

/// What is given, its mean with what is measured, or that; what was given none and differs by more than
/// chance keeps its own.
void Quantity::use(const Entry& e, RunConditions& run) {
  const std::optional<Pooled>& seen = e.given ? to_given_ : alone_;
  Estimate given{neutral(), e.given ? relative(e.given->value.sd, e.reference) : 0};
  if (seen) given.sd = std::hypot(given.sd, implied_sd_);
  Estimate used = given;
  double weight = 0;  // of the measured value
  if (seen && (!e.given || given.sd > 0)) {
    const Estimate measured{seen->mean.value, std::hypot(seen->mean.sd, common_)};
    used = e.given ? combined(given, measured) : measured;
    weight = e.given ? square(used.sd / measured.sd) : 1;
  }
  const bool mostly_measured = weight > 0.5, keeps_own = !e.given && !seen->one_value();
  const double value = keeps_own ? e.seen->value : applied(e, used.value);
  run.drive.*place_.in = value;
  if (place_.source == Source::amplitude) run.amplitude_from_track = mostly_measured;

  // What is common to all that is measured stands beside as errors of their own.
  const double sd = keeps_own         ? relative(e.seen->sd, value)
                    : mostly_measured ? std::hypot((1 - weight) * given.sd, weight * seen->mean.sd)
                                      : used.sd;
  if ((all_given_ || none_given_) && !keeps_own) {
    result_.shared_sd = sd;
    result_.known_beforehand = given.sd > 0 && !result_.assumed;
  } else {
    run.own.add(place_.parameter, square(absolute(sd, value)));
    if (keeps_own && place_.kind == Kind::frequency)  // the phase at the start went with it
      run.own.add(Parameter::angular_frequency, Parameter::start_phase,
                  (runs_[e.run].start_time - runs_[e.run].seen->middle_time) * square(e.seen->sd));
  }
  result_.by_measurement = result_.by_measurement || mostly_measured;
  result_.exact = result_.exact || (e.given && !(given.sd > 0) && !(implied_sd_ > 0));
  if (&e != first_) return;
  const double all = applied(e, used.value);
  result_.used = {all, absolute(used.sd, all)};
  result_.from = !e.given       ? (keeps_own ? From::each_its_own : From::measured)
                 : weight > 0   ? From::given_and_measured
                 : given.sd > 0 ? From::given
                                : From::given_exactly;
}

/// A diameter beside another scale checks that scale. A rim that is rounded or lit from one side shows
/// another radius: only a slip is one.
void compare_diameter(std::span<const RunEvidence> runs, const SharedEvidence& shared,
                      Conditions& conditions) {
  double sum = 0, relative_variance = 0;
  std::size_t count = 0;
  for (const RunEvidence& run : runs) {
    if (!run.diameter || run.scale->by == Source::diameter) continue;
    sum += run.diameter->value;
    relative_variance += square(run.scale->relative_sd) + square(run.diameter->sd / run.diameter->value);
    ++count;
  }
  if (count == 0 || !shared.diameter) return;
  const auto n = static_cast<double>(count);
  PooledQuantity diameter;
  diameter.quantity = Source::diameter;
  diameter.given = diameter.used = *shared.diameter;
  diameter.measured = {sum / n, sum / n * std::sqrt(relative_variance / n)};
  diameter.runs = count;
  if (std::abs(diameter.measured->value / diameter.given->value - 1) > kSlipShare)
    conditions.slips.push_back({Source::diameter, 0, {*diameter.given}, *diameter.measured, count, true});
  conditions.quantities.push_back(diameter);
}

}  // namespace

void pool_quantities(std::span<const RunEvidence> runs, const SharedEvidence& shared,
                     Conditions& conditions) {
  for (const Place& place : kPlaces) {
    Quantity quantity(place, runs, shared);
    if (!quantity.concerns_any()) continue;
    if (const auto slip = quantity.slip()) conditions.slips.push_back(*slip);
    conditions.quantities.push_back(quantity.settled(conditions.runs));
  }
  compare_diameter(runs, shared, conditions);
}

}  // namespace tribotrack::fit::internal

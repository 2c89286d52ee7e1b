#include "apps/measuring/track_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/measuring/likely_slip.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

using Kind = fit::MotionKind;

/// Of the amplitude, and sd of the mark: a circle leaves less.
constexpr double kNoCircle = 0.3, kBeyondNoise = 3;
constexpr double kAnotherFrequency = 0.2;  ///< as of a slip

double mm(double metres) {
  return 1e3 * metres;
}

double amplitude_of(const fit::PlatformMotion& platform) {
  return std::max(platform.amplitude.value, platform.amplitude_y.value);
}

bool circles(const fit::PlatformMotion& platform, const fit::TrackTable& table) {
  double sigma = 0;
  for (const double s : table.marker_sigma) sigma += s / static_cast<double>(table.marker_sigma.size());
  return platform.residual_rms < std::max(kNoCircle * amplitude_of(platform), kBeyondNoise * sigma);
}

/// The part against the mark, or the other way round: one distance.
bool keeps_to_mark(const fit::TrackTable& table) {
  fit::TrackTable apart = table;
  apart.marker.clear();
  if (!table.platform_frame)
    for (std::size_t i = 0; i < apart.position.size(); ++i) apart.position[i] -= table.marker[i];
  return fit::shown_motion(apart).kind == Kind::at_rest;
}

std::string w_of(const fit::Oscillation& o) {
  return fmt::format("{} rad/s", quoted(o.angular_frequency.value, o.angular_frequency.sd));
}

std::string sentence_of(const fit::ShownMotion& m, const fit::TrackTable& table) {
  const auto frame = [&](std::size_t row) { return table.frame[row]; };
  switch (m.kind) {
    case Kind::driven:
      return fmt::format(
          "the part is driven at {}: {:.1f} cycles of {:.3g} by {:.3g} mm, moving on by {:.3g} mm",
          w_of(*m.oscillation), m.oscillation->cycles, mm(m.oscillation->major), mm(m.oscillation->minor),
          mm(m.oscillation->drift));
    case Kind::swinging:
      return fmt::format(
          "the part swings at {}: {:.1f} cycles of {:.3g} mm{}, about a place that moves by {:.3g} mm",
          w_of(*m.oscillation), m.oscillation->cycles, mm(m.oscillation->major),
          m.oscillation->last_over_first < 0.95
              ? fmt::format(", in the end {:.0f} % of that in the beginning",
                            100 * m.oscillation->last_over_first)
              : "",
          mm(m.oscillation->drift));
    case Kind::slide:
      return fmt::format(
          "the part slides with constant deceleration, from about {:.3g} mm/s in frames {} to {}",
          mm(m.braking->speed), frame(m.braking->first), frame(m.braking->last - 1));
    case Kind::incline:
      return fmt::format(
          "the part gains speed evenly, by about {:.3g} mm/s^2 to {:.3g} mm/s in frames {} to {}, as down an "
          "incline",
          mm(-m.braking->deceleration), mm(m.braking->speed), frame(m.braking->first),
          frame(m.braking->last - 1));
    case Kind::pulled:
      return fmt::format(
          "the part moves on in one direction, by {:.3g} mm at {:.3g} mm/s on average, without constant "
          "deceleration, as a part that is pulled",
          mm(m.way), mm(m.speed));
    case Kind::at_rest:
      return fmt::format(
          "the part rests: it keeps within {:.2g} mm, its positions are uncertain by {:.2g} mm", mm(m.way),
          mm(m.noise));
    case Kind::with_background:
    case Kind::unknown:
      break;
  }
  return fmt::format(
      "the part moves by up to {:.3g} mm, and neither circles, nor swings, nor decelerates constantly, nor "
      "goes "
      "one way",
      mm(m.way));
}

}  // namespace

TrackMotion motion_of(const Track& track, const std::optional<fit::PlatformMotion>& platform) {
  TrackMotion motion;
  if (!platform) {
    motion.shown = fit::shown_motion(track.table);
    motion.sentence = sentence_of(motion.shown, track.table);
    return motion;
  }
  const double time = track.table.time.back() - track.table.time.front();
  if (circles(*platform, track.table)) {
    const fit::Estimate& w = platform->angular_frequency;
    motion.platform_seen = true;
    motion.shown.kind = Kind::driven;
    motion.sentence =
        fmt::format("the platform is driven at {} rad/s, {:.3g} by {:.3g} mm", quoted(w.value, w.sd),
                    mm(platform->amplitude.value), mm(platform->amplitude_y.value));
    motion.shown.oscillation = fit::Oscillation{.angular_frequency = w,
                                                .cycles = w.value * time / (2 * std::numbers::pi),
                                                .major = amplitude_of(*platform)};
    return motion;
  }
  motion.shown.kind = Kind::with_background;
  motion.sentence = fmt::format(
      "the mark moves and does not circle ({:.2g} mm rms are left of a circle of {:.2g} mm): the camera or "
      "the "
      "platform was moved{}",
      mm(platform->residual_rms), mm(amplitude_of(*platform)),
      keeps_to_mark(track.table) ? ", and the part goes with it" : "");
  return motion;
}

std::string TrackMotion::remedy() const {
  switch (shown.kind) {
    case Kind::driven:
      if (platform_seen) return "leave out --free-slide for alpha and v";
      return fmt::format("give --omega-rad-s {:.4g} for alpha and v, or track with --marker",
                         shown.oscillation->angular_frequency.value);
    case Kind::swinging:
      return "no friction follows from it; where a platform drives it give --omega-rad-s";
    case Kind::incline:
      return "for mu1 fit it as kind = \"free_slide\" with slope_rad";
    case Kind::pulled:
      return "for mu1 film a part that is let go and slides to rest, or choose those frames";
    case Kind::at_rest:
      return "film it while it moves, or track other frames";
    case Kind::with_background:
      return "fix the camera, or track with a mark on what the part slides on";
    case Kind::slide:
      return "leave out --omega-rad-s for mu1";
    case Kind::unknown:
      break;
  }
  return "is it the part that was tracked? see track --overlay, and choose the frames in which it slides or "
         "is "
         "driven";
}

std::string against_drive(const TrackMotion& motion, double angular_frequency) {
  switch (motion.shown.kind) {
    case Kind::slide:
    case Kind::incline:
    case Kind::at_rest:
    case Kind::with_background:
      return motion.sentence + ": no drive";
    case Kind::driven:
      break;
    default:
      return "";
  }
  const double seen = motion.shown.oscillation->angular_frequency.value, ratio = seen / angular_frequency;
  if (std::abs(ratio - std::max(1.0, std::round(ratio))) < kAnotherFrequency) return "";
  const std::string slip = likely_slip("angular_frequency_rad_s", angular_frequency, seen);
  return fmt::format("{}; given is {:.6g}{}", motion.sentence, angular_frequency,
                     slip.empty() ? "" : " (" + slip + ")");
}

}  // namespace tribotrack::apps

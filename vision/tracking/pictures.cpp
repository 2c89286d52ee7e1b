#include "vision/tracking/pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/io/levels.h"
#include "vision/registration/registration.h"

namespace tribotrack::vision {
namespace {

constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
constexpr int kContext = 4;  ///< px shown about the template

TemplateRegistration registration_of(const PartSetup& part, const Picture& first) {
  RegistrationOptions options;
  options.noise_variance = part.follow.noise_variance;
  options.template_noise_share = part.follow.template_noise_share;
  options.rotation = part.follow.rotation;
  return {part.average.picture(first), part.pattern, options};
}

/// The camera's pixels about the template at a pose.
Rect window_at(const Pattern& pattern, const Pose& pose, const Rect& bounds) {
  const Rect& w = pattern.window;
  const double x = w.x + pose.dx - kContext, y = w.y + pose.dy - kContext;
  return touched_pixels(x, y, x + w.width - 1 + 2 * kContext, y + w.height - 1 + 2 * kContext, bounds);
}

/// gain T + offset over a window of the camera, not known where the mask has no weight.
Picture predicted(const TemplateRegistration& registration, const Registration& fix, const Rect& window) {
  const Pattern& pattern = registration.pattern();
  Picture out = registration.at(fix.pose, window);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const int i = static_cast<int>(std::lround(window.x + x - fix.pose.dx)) - pattern.window.x;
      const int j = static_cast<int>(std::lround(window.y + y - fix.pose.dy)) - pattern.window.y;
      const bool in_mask = i >= 0 && j >= 0 && i < pattern.window.width && j < pattern.window.height &&
                           pattern.weights.at(i, j) > 0;
      const double level = fix.gain * static_cast<double>(out.at(x, y)) + fix.offset;
      out.at(x, y) = in_mask ? static_cast<float>(level) : kNotKnown;
    }
  return out;
}

}  // namespace

void show_template(const PartSetup& part, const Picture& first, DebugSink& sink) {
  const TemplateRegistration registration = registration_of(part, first);
  const Rect& window = part.pattern.window;
  const Point at{static_cast<double>(window.x), static_cast<double>(window.y)};
  sink.show(StagePicture{
      .name = "first_pass_template",
      .title = "template of the first pass, average of " + std::to_string(part.average.frames) + " frame(s)",
      .why_frame = "where the part is in the first frame",
      .levels = registration.at({}, window),
      .first = at,
      .place = "of the camera"});
  Picture weights = part.pattern.weights;
  const Picture chosen = registration.chosen();
  for (std::size_t k = 0; k < weights.levels().size(); ++k)
    weights.levels()[k] = 0.5F * (weights.levels()[k] + chosen.levels()[k]);
  sink.show(StagePicture{.name = "first_pass_weights",
                         .title = "pixels of the template: 1 used, 0.5 in the mask but not informative",
                         .why_frame = "where the part is in the first frame",
                         .levels = std::move(weights),
                         .unit = "weight",
                         .first = at,
                         .place = "of the camera",
                         .low = 0,
                         .high = 1});
}

void show_first_pass(const PartSetup& part, const Picture& first, const FirstPassResult& result,
                     const Track& track, const std::vector<ShownFrame>& frames, FrameSource& source,
                     DebugSink& sink) {
  TemplateRegistration registration = registration_of(part, first);
  for (const ShownFrame& shown : frames) {
    const auto place = static_cast<std::size_t>(shown.index - result.first_index);
    const TrackPoint& point = track.points[place];
    const Pose pose{point.x - part.pattern.centre.x, point.y - part.pattern.centre.y, result.theta[place]};
    const Rect window = window_at(part.pattern, pose, source.bounds());
    StagePicture seen{.name = "window",
                      .title = "the camera's picture about the part",
                      .frame = point.frame,
                      .why_frame = shown.why,
                      .levels = {},
                      .first = {static_cast<double>(window.x), static_cast<double>(window.y)},
                      .place = "of the camera"};
    source.read(shown.index, window, seen.levels);
    const Registration fix = registration.refine(seen.levels, window.x, window.y, pose);
    StagePicture model = seen, residual = seen;
    model.name = "first_pass_predicted";
    model.title = "the template at the measured place, its gain and offset fitted";
    model.levels = predicted(registration, fix, window);
    residual.name = "first_pass_residual";
    residual.title = "first pass: camera minus prediction";
    residual.levels = difference(seen.levels, model.levels);
    residual.zero_centred = true;
    share_range(seen, model);
    sink.show(seen);
    sink.show(model);
    sink.show(residual);
  }
}

}  // namespace tribotrack::vision

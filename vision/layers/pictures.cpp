#include "vision/layers/pictures.h"

#include <cmath>
#include <limits>

#include "vision/io/window.h"

namespace tribotrack::vision {
namespace {

constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
constexpr double kBeyondRim = 4;     ///< px shown about the disc
constexpr double kKnownShare = 0.5;  ///< of the variance of a place never seen: below it a place is known

Point first_of(const Rect& region) {
  return {static_cast<double>(region.x), static_cast<double>(region.y)};
}

/// Levels at the places of the region, not known where it was neither uncovered nor seen through the rim.
Picture background(const GroundPicture& ground) {
  const Rect& region = ground.region();
  Picture value(region.width, region.height), known(region.width, region.height);
  ground.sample(region.x, region.y, region.width, region.height, value.levels().data(),
                known.levels().data());
  for (std::size_t k = 0; k < value.levels().size(); ++k)
    if (!(known.levels()[k] > 0) && !(ground.variance().levels()[k] < kKnownShare * ground.unseen_variance()))
      value.levels()[k] = kNotKnown;
  return value;
}

Picture square_roots(Picture picture) {
  for (float& level : picture.levels()) level = std::sqrt(std::max(0.0F, level));
  return picture;
}

StageCurve rim_curve(const RimProfile& rim) {
  StageCurve curve{.name = "layers_rim_profile",
                   .title = "rim profile: the disc's share of a pixel against the distance from its centre",
                   .x_label = "distance from the centre, px",
                   .y_label = "share of the disc, alpha = 1 - w",
                   .points = {}};
  for (double rho = std::max(0.0, rim.inner() - 1); rho <= rim.outer() + 1; rho += 0.25)
    curve.points.push_back({rho, 1 - rim.at(rho)});
  return curve;
}

void show_illumination(const StaticIllumination& light, DebugSink& sink) {
  StagePicture gain{.name = "layers_illumination_gain",
                    .title = "static illumination: gain L of I = L scene + H",
                    .levels = light.gain(),
                    .unit = "gain",
                    .first = first_of(light.region()),
                    .place = "of the camera"};
  StagePicture offset{.name = "layers_illumination_offset",
                      .title = "static illumination: offset H of I = L scene + H",
                      .levels = light.offset(),
                      .first = first_of(light.region()),
                      .place = "of the camera"};
  for (std::size_t k = 0; k < gain.levels.levels().size(); ++k)
    if (light.hidden().levels()[k] > 0) gain.levels.levels()[k] = offset.levels.levels()[k] = kNotKnown;
  sink.show(gain);
  sink.show(offset);
}

/// The model of state.h over a window of the camera.
Picture predicted(const LearntLayers& layers, const LayeredState& state, const Rect& window) {
  const QuinticSpline disc(layers.disc.at(state.theta)), share(layers.disc.share());
  const Rect& region = layers.ground.region();
  const double half = layers.disc.half();
  Picture out(window.width, window.height);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double u = window.x + x - state.centre.x, v = window.y + y - state.centre.y;
      const SplineSample ground = layers.ground.spline().sample(window.x + x - state.ground.x - region.x,
                                                                window.y + y - state.ground.y - region.y);
      double shown = 0;
      SplineSample w{1, 0, 0};
      if (std::abs(u) <= half && std::abs(v) <= half) {
        shown = disc.value(half + u, half + v);
        w = share.sample(half + u, half + v);
      }
      const double blended = layers.disc.blend() * (w.slope_x * ground.slope_x + w.slope_y * ground.slope_y);
      out.at(x, y) = static_cast<float>(state.gain * (1 + state.slope_x * u + state.slope_y * v) * shown +
                                        state.ground_gain * (w.value * ground.value + blended));
    }
  if (layers.illumination) layers.illumination->put_in(out, window.x, window.y);
  return out;
}

}  // namespace

void show_layers(const LearntLayers& layers, DebugSink& sink) {
  const double half = layers.disc.half();
  const Rect& region = layers.ground.region();
  sink.show(StagePicture{.name = "layers_disc",
                         .title = "the disc learnt, on a plain ground of the background's mean",
                         .levels = layers.disc.on_plain(layers.ground.mean()),
                         .first = {-half, -half},
                         .place = "from the disc's centre"});
  sink.show(StagePicture{.name = "layers_weights",
                         .title = "pixels about the disc that are used one by one",
                         .levels = layers.weights,
                         .unit = "weight",
                         .first = {-half, -half},
                         .place = "from the disc's centre",
                         .low = 0,
                         .high = 1});
  sink.show(StagePicture{.name = "layers_ground",
                         .title = "the background learnt (the platform)",
                         .levels = background(layers.ground),
                         .first = first_of(region),
                         .place = "of the platform"});
  sink.show(StagePicture{.name = "layers_ground_sd",
                         .title = "standard deviation of the background",
                         .levels = square_roots(layers.ground.variance()),
                         .first = first_of(region),
                         .place = "of the platform"});
  sink.show(rim_curve(layers.disc.rim()));
  if (layers.illumination) show_illumination(*layers.illumination, sink);
}

void show_layered_frame(const LearntLayers& layers, const LayeredState& state, const ShownFrame& shown,
                        FrameSource& source, DebugSink& sink) {
  const Rect window = window_about(state.centre, layers.disc.rim().outer() + kBeyondRim, source.bounds());
  Picture seen;
  source.read(shown.index, window, seen);
  StagePicture model{.name = "layers_predicted",
                     .title = "disc over background at the measured place",
                     .frame = source.number(shown.index),
                     .why_frame = shown.why,
                     .levels = predicted(layers, state, window),
                     .first = first_of(window),
                     .place = "of the camera"};
  StagePicture residual = model;
  residual.name = "layers_residual";
  residual.title = "layers: camera minus prediction";
  residual.levels = difference(seen, model.levels);
  residual.zero_centred = true;
  sink.show(model);
  sink.show(residual);
}

}  // namespace tribotrack::vision

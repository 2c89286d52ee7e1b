#include "vision/layers/pictures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/io/levels.h"

namespace tribotrack::vision {
namespace {

constexpr double kBeyond = 2;  ///< px shown about the part's grid

Point first_of(const Rect& region) {
  return {static_cast<double>(region.x), static_cast<double>(region.y)};
}

Picture square_roots(Picture picture) {
  for (float& level : picture.levels()) level = std::sqrt(std::max(0.0F, level));
  return picture;
}

Picture ground_levels(const GroundPicture& ground) {
  const Rect& region = ground.region();
  Picture level(region.width, region.height), variance(region.width, region.height);
  ground.sample(region.x, region.y, region.width, region.height, level.levels().data(),
                variance.levels().data());
  for (float& l : level.levels()) l += static_cast<float>(ground.mean());
  return level;
}

/// The model of state.h over a window of the camera.
Picture predicted(const LearntLayers& layers, const LayeredState& state, const Rect& window) {
  Picture shown = layers.part.level;
  if (layers.texture) {
    const Picture turned = layers.texture->at(state.theta);
    for (std::size_t i = 0; i < shown.levels().size(); ++i) shown.levels()[i] += turned.levels()[i];
  }
  const QuinticSpline level(shown), share(layers.part.share);
  const Rect& region = layers.ground.region();
  const double half = layers.part.half;
  Picture out(window.width, window.height);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double u = window.x + x - state.centre.x, v = window.y + y - state.centre.y;
      const SplineSample ground = layers.ground.spline().sample(window.x + x - state.ground.x - region.x,
                                                                window.y + y - state.ground.y - region.y);
      const bool on_grid = std::abs(u) <= half && std::abs(v) <= half;
      const double part = on_grid ? level.value(half + u, half + v) : layers.ground.mean();
      const SplineSample shows = on_grid ? share.sample(half + u, half + v) : SplineSample{1, 0, 0};
      const double blended =
          layers.part.blend * (shows.slope_x * ground.slope_x + shows.slope_y * ground.slope_y);
      const double shine = state.gain * (1 + state.slope_x * u + state.slope_y * v),
                   mean = layers.ground.mean();
      out.at(x, y) = static_cast<float>(shine * (part - shows.value * mean) +
                                        state.ground_gain * (shows.value * (ground.value + mean) + blended));
    }
  return out;
}

}  // namespace

void show_layers(const LearntLayers& layers, DebugSink& sink) {
  const double half = layers.part.half;
  const Rect& region = layers.ground.region();
  const auto on_part = [&](const char* name, const char* title, Picture levels, const char* unit) {
    sink.show(StagePicture{.name = name,
                           .title = title,
                           .levels = std::move(levels),
                           .unit = unit,
                           .first = {-half, -half},
                           .place = "from the part's centre"});
  };
  on_part("layers_part", "the part learnt, on ground of mean level", layers.part.level, "grey levels");
  if (layers.texture)
    on_part("layers_texture", "what turns with the part", layers.texture->at(0), "grey levels");
  on_part("layers_share", "share of the ground that shows", layers.part.share, "share");
  on_part("layers_part_sd", "standard deviation left unexplained", square_roots(layers.part.variance),
          "grey levels");
  on_part("layers_weights", "pixels about the part that are used", layers.chosen, "weight");
  sink.show(StagePicture{.name = "layers_ground",
                         .title = "the background learnt (the platform)",
                         .levels = ground_levels(layers.ground),
                         .first = first_of(region),
                         .place = "of the platform"});
  sink.show(StagePicture{.name = "layers_ground_sd",
                         .title = "standard deviation of the background",
                         .levels = square_roots(layers.ground.variance()),
                         .first = first_of(region),
                         .place = "of the platform"});
}

void show_layered_frame(const LearntLayers& layers, const LayeredState& state, const ShownFrame& shown,
                        FrameSource& source, DebugSink& sink) {
  const Rect window = window_about(state.centre, layers.part.half + kBeyond, source.bounds());
  Picture seen;
  source.read(shown.index, window, seen);
  StagePicture model{.name = "layers_predicted",
                     .title = "part over background at the measured place",
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

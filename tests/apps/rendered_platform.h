// Recordings of a circling platform with a disc, a marker and the gate's lamp, rendered and tracked in
// memory.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "fit/gate_timing.h"
#include "fit/measurement.h"
#include "model/friction.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::test {

struct RenderedPlatform {
  double radius_px = 2.8, w = 62.8, phase_at_zero = 0.4, epsilon = std::numbers::pi / 2;
  double phi = 1.2, dtau = std::numbers::pi / 3;
  double rate = 500, exposure = 2e-3, duration = 2;
  double noise = 2;
  std::uint64_t seed = 1;
  bool marker = true;
  double texture_rms = 6;
};

/// Frames rendered when they are asked for, and kept until the next.
class RenderedPlatformSource : public vision::FrameSource {
 public:
  explicit RenderedPlatformSource(const RenderedPlatform& truth) : truth_(truth), renderer_(scene_of(truth)) {
    info_.path = "rendered";
    info_.width = renderer_.scene().width;
    info_.height = renderer_.scene().height;
    info_.bits = 8;
    info_.frame_count = static_cast<std::int64_t>(truth.rate * truth.duration);
    info_.time_base.rate_hz = truth.rate;
    info_.time_base.source = "test";
    info_.exposure_s = truth.exposure;
  }
  void read(std::int64_t index, const vision::Rect& window, vision::Picture& picture) override {
    if (index != current_) {
      const double t = static_cast<double>(index) / truth_.rate;
      const auto phase = [&](double time) { return truth_.w * time + truth_.phase_at_zero; };
      model::Friction gate;
      gate.phase = truth_.phi;
      gate.pulse_width = truth_.dtau;
      frame_ = renderer_.render(
          index, t, truth_.exposure,
          [&](double time) {
            vision::ScenePose pose;
            pose.platform = {truth_.radius_px * std::cos(phase(time)),
                             -truth_.radius_px * std::cos(phase(time) + truth_.epsilon)};
            pose.disc = {100 + pose.platform.x + 5 * time, 60 + pose.platform.y - 3 * time};
            return pose;
          },
          model::gate_share(gate, phase(t - truth_.exposure / 2), phase(t + truth_.exposure / 2)));
      current_ = index;
    }
    if (picture.width() != window.width || picture.height() != window.height)
      picture = vision::Picture(window.width, window.height);
    for (int y = 0; y < window.height; ++y)
      std::copy_n(frame_.row(window.y + y).begin() + window.x, window.width, picture.row(y).begin());
  }
  using FrameSource::read;

 private:
  static vision::Scene scene_of(const RenderedPlatform& truth) {
    vision::Scene scene;
    scene.width = 160;
    scene.height = 120;
    scene.disc.radius_px = 30;
    scene.disc.scratch_contrast = 12;
    scene.platform.level = 70;
    scene.platform.texture_rms = truth.texture_rms;
    if (truth.marker) scene.marker = vision::MarkerAppearance{{30, 32}, 14};
    scene.lamp = vision::Lamp{{20, 95}, 6};
    scene.read_noise = truth.noise;
    scene.seed = truth.seed;
    return scene;
  }

  RenderedPlatform truth_;
  vision::SceneRenderer renderer_;
  std::int64_t current_ = -1;
  vision::Picture frame_;
};

struct MeasuredPlatform {
  vision::TrackResult track;
  std::optional<fit::PlatformMotion> platform;  ///< lengths in px, as if a pixel were a metre
  fit::GateMeasurement gate;
};

inline MeasuredPlatform measure(const RenderedPlatform& truth) {
  RenderedPlatformSource source(truth);
  vision::TrackOptions options;
  options.layers = vision::Layers::off;
  options.target = {vision::Target::Kind::disc,
                    {100 + truth.radius_px * std::cos(truth.phase_at_zero),
                     60 - truth.radius_px * std::cos(truth.phase_at_zero + truth.epsilon), 30},
                    {}};
  options.marker.kind = vision::MarkerChoice::Kind::find;
  options.gate = vision::Circle{20, 95, 5};
  MeasuredPlatform measured;
  measured.track = vision::track(source, options);
  fit::TrackTable table;
  fit::LampRecord lamp;
  table.exposure = truth.exposure;
  lamp.exposure = truth.exposure;
  for (const vision::TrackPoint& p : measured.track.track.points) {
    lamp.time.push_back(p.time_s);
    lamp.level.push_back(p.gate.value());
    if (!p.marker) continue;
    table.time.push_back(p.time_s);
    table.marker.emplace_back(p.marker->x, -p.marker->y);
    table.marker_sigma.push_back(p.marker->sigma);
  }
  measured.platform = fit::measure_platform_motion(table);
  if (measured.platform) {
    const fit::PlatformMotion& m = *measured.platform;
    measured.gate =
        fit::measure_gate(lamp, {m.angular_frequency.value, m.phase_at_zero.value, m.phase_at_middle.sd});
  }
  return measured;
}

}  // namespace tribotrack::test

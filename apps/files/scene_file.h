// SCENE.toml: what `synth` renders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/scenario_file.h"
#include "apps/text/json.h"
#include "vision/frame_sink.h"
#include "vision/scene.h"

namespace tribotrack::apps {

/// One recording to render: look, motion and camera.
struct SceneShot {
  std::string name;  ///< empty unless it comes from a [[shot]]
  vision::Scene scene;
  ScenarioFile motion;  ///< [platform], [friction], [run]
  double mm_per_px = 0.1;
  double xi_axis_rad = 0;
  double frame_rate_hz = 250;
  double exposure_s = 0.5e-3;
  int frames = 0;  ///< [video] frames, else as many as the run's cycles need
  vision::SinkOptions sink;
  std::optional<vision::Point>
      start_px;  ///< the disc's centre at the start; empty: so that its path is centred in the picture
  double theta_rad = 0, spin_rad_s = 0;
};

/// Reads a scene. Without [[shot]] one shot; with them one each, `name` and any scenario parameter (phi_rad,
/// dtau_rad, ...) or `seed` overriding the scene's.
std::vector<SceneShot> read_scene_file(const std::filesystem::path& file);

Json json_of(const SceneShot& shot);

}  // namespace tribotrack::apps

#include "apps/files/scene_file.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "apps/files/scenario_file.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

template <class T>
void take(T& target, const std::optional<double>& value) {
  if (value) target = static_cast<T>(*value);
}

void read_video(StrictTable& table, SceneShot& shot) {
  const auto size = [&](const char* key, int fallback) {
    const auto value = table.integer(key).value_or(fallback);
    if (value < 8 || value > 16384)
      table.fail(key, fmt::format("must be between 8 and 16384, not {}", value));
    return static_cast<int>(value);
  };
  shot.scene.width = size("width", shot.scene.width);
  shot.scene.height = size("height", shot.scene.height);
  const auto bits = table.integer("bits").value_or(8);
  if (bits != 8 && bits != 10 && bits != 12)
    table.fail("bits", fmt::format("must be 8, 10 or 12, not {}", bits));
  shot.scene.bits = static_cast<int>(bits);
  take(shot.frame_rate_hz, table.positive("frame_rate_hz"));
  take(shot.exposure_s, table.positive("exposure_s"));
  if (shot.exposure_s * shot.frame_rate_hz > 1)
    table.fail("exposure_s", "is longer than the time between two frames");
  const auto frames = table.integer("frames").value_or(0);
  if (frames < 0) table.fail("frames", "must not be negative");
  shot.frames = static_cast<long>(frames);
  using vision::Codec;
  const auto codec = table.choice("codec", {"automatic", "cine", "ffv1", "mjpeg", "h264", "png", "tiff"});
  if (codec) shot.sink.codec = static_cast<Codec>(*codec);
  const auto quality = table.integer("crf").value_or(18);
  if (quality < 0 || quality > 51) table.fail("crf", "must be between 0 (lossless) and 51");
  shot.sink.crf = static_cast<int>(quality);
  table.finish();
}

void read_camera(StrictTable& table, SceneShot& shot) {
  take(shot.mm_per_px, table.positive("mm_per_px"));
  take(shot.xi_axis_rad, table.angle("xi_axis_rad"));
  take(shot.scene.vignetting, table.not_negative("vignetting"));
  take(shot.scene.flicker, table.not_negative("flicker"));
  take(shot.scene.flicker_hz, table.positive("flicker_hz"));
  take(shot.scene.read_noise, table.not_negative("read_noise"));
  take(shot.scene.shot_noise, table.not_negative("shot_noise"));
  table.finish();
}

std::optional<vision::Point> read_point(StrictTable& table, const char* key) {
  const auto values = table.numbers(key, 2);
  if (!values) return std::nullopt;
  return vision::Point{(*values)[0], (*values)[1]};
}

void read_disc(StrictTable& table, SceneShot& shot) {
  auto& disc = shot.scene.disc;
  const auto diameter = table.positive("diameter_mm");
  const auto radius = table.positive("radius_px");
  if (diameter && radius) table.fail("radius_px", "and `diameter_mm` mean the same; give one of them");
  if (diameter) disc.radius_px = *diameter / (2 * shot.mm_per_px);
  if (radius) disc.radius_px = *radius;
  shot.start_px = read_point(table, "start_px");
  take(shot.theta_rad, table.angle("theta_rad"));
  take(shot.spin_rad_s, table.number("spin_rad_s"));
  take(disc.level, table.number("level"));
  take(disc.edge_blur_px, table.positive("edge_blur_px"));
  const auto scratches = table.not_negative("scratches");
  if (scratches.value_or(0) > 10000)
    table.fail("scratches", fmt::format("must be between 0 and 10000, not {}", *scratches));
  take(disc.scratches, scratches);
  take(disc.scratch_contrast, table.number("scratch_contrast"));
  take(disc.highlight, table.number("highlight"));
  disc.visible = table.boolean("visible").value_or(true);
  table.finish();
}

void read_surface(StrictTable& table, vision::PlatformAppearance& surface) {
  take(surface.level, table.number("level"));
  take(surface.texture_rms, table.not_negative("texture_rms"));
  take(surface.brush_angle_rad, table.angle("brush_angle_rad"));
  take(surface.texture_length_px, table.positive("texture_length_px"));
  take(surface.texture_width_px, table.positive("texture_width_px"));
  table.finish();
}

vision::MarkerAppearance read_marker(StrictTable& table) {
  vision::MarkerAppearance marker;
  const auto position = read_point(table, "position_px");
  if (!position) table.fail("position_px", "is missing: the marker's centre, [x, y]");
  marker.position = *position;
  take(marker.radius_px, table.positive("radius_px"));
  take(marker.level, table.number("level"));
  take(marker.ring_level, table.number("ring_level"));
  table.finish();
  return marker;
}

vision::Lamp read_lamp(StrictTable& table) {
  vision::Lamp lamp;
  const auto position = read_point(table, "position_px");
  if (!position) table.fail("position_px", "is missing: the lamp's centre, [x, y]");
  lamp.position = *position;
  take(lamp.radius_px, table.positive("radius_px"));
  take(lamp.on_level, table.number("on_level"));
  take(lamp.off_level, table.number("off_level"));
  table.finish();
  return lamp;
}

SceneShot shot_of(StrictTable table, const SceneShot& base) {
  SceneShot shot = base;
  shot.name = table.text("name").value_or("");
  if (shot.name.empty() || shot.name.find('/') != std::string::npos)
    throw InvalidInput(fmt::format("{}: a [[shot]] needs a `name` that can be a file's", table.place()));
  if (table.has("mu2") && table.has("mu1_over_mu2"))
    table.fail("mu2", "and `mu1_over_mu2` mean the same; give one of them");
  const auto set = [&](const std::string& name) {
    const auto value = name.ends_with("_rad") ? table.angle(name) : table.number(name);
    if (value) set_scenario_parameter(shot.motion, name, *value);
  };
  for (const KeyFacts& key : scenario_parameters()) {
    set(key.name);
    for (const OtherName& other : other_names(key.name))
      if (table.has(other.name)) set(other.name);
  }
  if (const auto seed = table.integer("seed")) shot.scene.seed = static_cast<std::uint64_t>(*seed);
  if (const auto start = read_point(table, "start_px")) shot.start_px = start;
  table.finish();
  return shot;
}

}  // namespace

std::vector<SceneShot> read_scene_file(const std::filesystem::path& file) {
  StrictTable top = StrictTable::read(file);
  require_kind(top, TomlKind::scene, file.string());
  SceneShot base;
  base.motion = read_scenario_tables(top);
  base.scene.seed = static_cast<std::uint64_t>(top.integer("seed").value_or(1));
  if (auto table = top.table("camera"))
    read_camera(*table, base);  // before the disc: its diameter needs the scale
  if (auto table = top.table("video")) read_video(*table, base);
  if (auto table = top.table("disc")) read_disc(*table, base);
  if (auto table = top.table("surface")) read_surface(*table, base.scene.platform);
  if (auto table = top.table("marker")) base.scene.marker = read_marker(*table);
  if (auto table = top.table("lamp")) base.scene.lamp = read_lamp(*table);
  std::vector<SceneShot> shots;
  for (StrictTable& table : top.tables("shot")) shots.push_back(shot_of(table, base));
  top.finish();
  if (shots.empty()) shots.push_back(base);
  for (SceneShot& shot : shots) {
    shot.motion.settle();
    if (double& radius = shot.motion.scenario.spin.radius; radius == 0)
      radius = shot.scene.disc.radius_px * shot.mm_per_px * 1e-3;
    shot.motion.scenario.validate();
    shot.scene.validate();
  }
  return shots;
}

Json json_of(const SceneShot& shot) {
  const vision::Scene& s = shot.scene;
  Json json = json_of(shot.motion.scenario);
  json["width"] = s.width;
  json["height"] = s.height;
  json["bits"] = s.bits;
  json["frame_rate_hz"] = shot.frame_rate_hz;
  json["exposure_s"] = shot.exposure_s;
  json["mm_per_px"] = shot.mm_per_px;
  json["xi_axis_rad"] = shot.xi_axis_rad;
  json["disc_radius_px"] = s.disc.radius_px;
  json["read_noise"] = s.read_noise;
  json["shot_noise"] = s.shot_noise;
  json["texture_rms"] = s.platform.texture_rms;
  json["seed"] = s.seed;
  return json;
}

}  // namespace tribotrack::apps

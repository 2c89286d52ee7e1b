#include "apps/files/scene_file.h"

#include <fmt/format.h>

#include "apps/files/scenario_file.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

using S = SceneShot;
using vision::Scene, vision::Lamp;
using Disc = vision::DiscAppearance;
using Platform = vision::PlatformAppearance;
using Mark = vision::MarkerAppearance;

const Keys<S> kVideoKeys = {{"width", Kind::wholes(8, 16384), at<&S::scene, &Scene::width>},
                            {"height", Kind::wholes(8, 16384), at<&S::scene, &Scene::height>},
                            {"bits", Kind::wholes(8, 12), at<&S::scene, &Scene::bits>},
                            {"frame_rate_hz", Kind::above_zero, at<&S::frame_rate_hz>},
                            {"exposure_s", Kind::above_zero, at<&S::exposure_s>},
                            {"frames", Kind::wholes(0, 1'000'000'000), at<&S::frames>},
                            {"crf", Kind::wholes(0, 51), at<&S::sink, &vision::SinkOptions::crf>}};

const Keys<S> kViewKeys = {{"mm_per_px", Kind::above_zero, at<&S::mm_per_px>},
                           {"xi_axis_rad", Kind::angle, at<&S::xi_axis_rad>},
                           {"vignetting", Kind::not_negative, at<&S::scene, &Scene::vignetting>},
                           {"flicker", Kind::not_negative, at<&S::scene, &Scene::flicker>},
                           {"flicker_hz", Kind::above_zero, at<&S::scene, &Scene::flicker_hz>},
                           {"read_noise", Kind::not_negative, at<&S::scene, &Scene::read_noise>},
                           {"shot_noise", Kind::not_negative, at<&S::scene, &Scene::shot_noise>}};

const Keys<S> kDiscKeys = {
    {"radius_px", Kind::above_zero, at<&S::scene, &Scene::disc, &Disc::radius_px>},
    {"theta_rad", Kind::angle, at<&S::theta_rad>},
    {"spin_rad_s", Kind::number, at<&S::spin_rad_s>},
    {"level", Kind::number, at<&S::scene, &Scene::disc, &Disc::level>},
    {"edge_blur_px", Kind::above_zero, at<&S::scene, &Scene::disc, &Disc::edge_blur_px>},
    {"scratches", Kind::wholes(0, 10000), at<&S::scene, &Scene::disc, &Disc::scratches>},
    {"scratch_contrast", Kind::number, at<&S::scene, &Scene::disc, &Disc::scratch_contrast>},
    {"highlight", Kind::number, at<&S::scene, &Scene::disc, &Disc::highlight>}};

const Keys<Platform> kSurfaceKeys = {
    {"level", Kind::number, at<&Platform::level>},
    {"texture_rms", Kind::not_negative, at<&Platform::texture_rms>},
    {"brush_angle_rad", Kind::angle, at<&Platform::brush_angle_rad>},
    {"texture_length_px", Kind::above_zero, at<&Platform::texture_length_px>},
    {"texture_width_px", Kind::above_zero, at<&Platform::texture_width_px>}};

const Keys<Mark> kMarkKeys = {{"radius_px", Kind::above_zero, at<&Mark::radius_px>},
                              {"level", Kind::number, at<&Mark::level>},
                              {"ring_level", Kind::number, at<&Mark::ring_level>}};

const Keys<Lamp> kLampKeys = {{"radius_px", Kind::above_zero, at<&Lamp::radius_px>},
                              {"on_level", Kind::number, at<&Lamp::on_level>},
                              {"off_level", Kind::number, at<&Lamp::off_level>}};

void read_video(StrictTable& table, SceneShot& shot) {
  read_keys(table, kVideoKeys, shot);
  if (const int bits = shot.scene.bits; bits != 8 && bits != 10 && bits != 12)
    table.fail("bits", fmt::format("must be 8, 10 or 12, not {}", bits));
  if (shot.exposure_s * shot.frame_rate_hz > 1)
    table.fail("exposure_s", "is longer than the time between two frames");
  const auto codec = table.choice("codec", {"automatic", "cine", "ffv1", "mjpeg", "h264", "png", "tiff"});
  if (codec) shot.sink.codec = static_cast<vision::Codec>(*codec);
}

std::optional<vision::Point> read_point(StrictTable& table, const char* key) {
  const auto values = table.numbers(key, 2);
  if (!values) return std::nullopt;
  return vision::Point{(*values)[0], (*values)[1]};
}

void read_disc(StrictTable& table, SceneShot& shot) {
  read_keys(table, kDiscKeys, shot);
  const auto diameter = table.positive("diameter_mm");
  if (diameter && table.has("radius_px"))
    table.fail("radius_px", "and `diameter_mm` mean the same; give one of them");
  if (diameter) shot.scene.disc.radius_px = *diameter / (2 * shot.mm_per_px);
  shot.start_px = read_point(table, "start_px");
  shot.scene.disc.visible = table.boolean("visible").value_or(true);
}

/// Of a marker or a lamp.
template <class Thing>
void read_thing(StrictTable& table, const Keys<Thing>& keys, std::optional<Thing>& thing) {
  thing.emplace();
  read_keys(table, keys, *thing);
  const auto position = read_point(table, "position_px");
  if (!position) table.fail("position_px", "is missing: its centre, [x, y]");
  thing->position = *position;
}

SceneShot shot_of(StrictTable table, const SceneShot& base) {
  SceneShot shot = base;
  shot.name = table.text("name").value_or("");
  if (shot.name.empty() || shot.name.find('/') != std::string::npos)
    throw InvalidInput("{}: a [[shot]] needs a `name` that can be a file's", table.place());
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
  const auto section = [&](const char* name, const auto& read) {
    if (auto table = top.table(name)) {
      read(*table);
      table->finish();
    }
  };
  section("camera", [&](StrictTable& table) { read_keys(table, kViewKeys, base); });
  section("video", [&](StrictTable& table) { read_video(table, base); });
  section("disc", [&](StrictTable& table) { read_disc(table, base); });  // its diameter needs the scale
  section("surface", [&](StrictTable& table) { read_keys(table, kSurfaceKeys, base.scene.platform); });
  section("marker", [&](StrictTable& table) { read_thing(table, kMarkKeys, base.scene.marker); });
  section("lamp", [&](StrictTable& table) { read_thing(table, kLampKeys, base.scene.lamp); });
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
  Json json = json_of(shot.motion.scenario);
  json.update(written(kVideoKeys, shot));
  json.update(written(kViewKeys, shot));
  json["disc_radius_px"] = shot.scene.disc.radius_px;
  json["texture_rms"] = shot.scene.platform.texture_rms;
  json["seed"] = shot.scene.seed;
  return json;
}

}  // namespace tribotrack::apps

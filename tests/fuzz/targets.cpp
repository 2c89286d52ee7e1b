// One target for each kind of file that may come from others: what is in it is either read or refused (see
// target.h). By itself this program reads every file of the corpus once, each folder by the target of its
// name: an ordinary test. With FUZZ_TARGET it is that target's program of libFuzzer.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>

#include "apps/files/camera.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/scenario_file.h"
#include "apps/files/scene_file.h"
#include "apps/files/traces/scope_file.h"
#include "apps/files/track_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/report/data/data.h"
#include "fuzz/target.h"
#include "vision/frame_source.h"

namespace tribotrack::fuzz {
namespace {

void read_scene(const std::filesystem::path& file) try {
  for (const apps::SceneShot& shot : apps::read_scene_file(file)) apps::text_of(apps::json_of(shot));
} catch (const std::invalid_argument& refusal) {  // of Scene::validate
  throw apps::InvalidInput(refusal.what());
}

void read_scenario(const std::filesystem::path& file) {
  const model::Scenario scenario = apps::read_scenario_file(file).scenario;
  scenario.validate();
  apps::text_of(apps::json_of(scenario));
}

/// Of another program, with all that its file may leave open given.
void read_foreign_track(const std::filesystem::path& file) {
  apps::TrackReading reading;
  reading.unit = "mm";
  reading.y = "up";
  reading.mm_per_px = 0.1;
  apps::read_any_track(file, reading);
}

/// Its head, its times, and the pictures that its table points to.
void read_frames(const Hostile& cine, const std::filesystem::path& file) {
  std::unique_ptr<vision::FrameSource> source;
  cine.read_or_refuse([&] { source = vision::open_source(file); });
  vision::bytes_before_pictures(file);
  if (!source) return;
  const auto& info = source->info();
  const std::int64_t last = info.frame_count - 1;
  const vision::Rect corner{info.width - 1, info.height - 1, 1, 1};
  vision::Picture picture;
  for (const std::int64_t index : {std::int64_t{0}, std::min<std::int64_t>(1, last), last / 2, last})
    cine.read_or_refuse([&] {
      source->read(index, corner, picture);
      source->read(index, source->bounds(), picture);
      if (info.time_base.known()) source->time_s(index);
      source->exposure_s(index);
    });
}

void read_cine(const Hostile& cine) {
  read_frames(cine, cine.as("a.cine"));
}

/// What a .cih or a .cihx says of the bare pixels beside it.
void read_photron(const Hostile& sidecar) {
  const bool xml = sidecar.text.find("<cih>") != std::string_view::npos;
  const auto pixels = sidecar.folder.write(xml ? "x.mraw" : "t.mraw", std::string(600, 'p'));
  sidecar.as(xml ? "x.cihx" : "t.cih");
  read_frames(sidecar, pixels);
}

/// fit.json, as `report` reads it, beside a meta file that is as it should be. Its runs were measured
/// elsewhere: tracks have a target of their own.
void read_fit(const Hostile& fit) {
  fit.folder.write("fit.json.meta.json",
                   R"({"program": "tribotrack", "version": "0.1.0", "schema": 1, "command": "run",
          "inputs": [{"path": "c/campaign.toml", "xxh3_128": "00"}],
          "configuration": {"platform": {"amplitude_mm": 0.28, "amplitude_mm_sd": 0.01},
            "part": {"diameter_mm": 6.0, "diameter_mm_sd": 0}, "fit": {"fixed": {"mu2": 0.1}},
            "runs": [{"alpha_rad": 1, "alpha_sd_rad": 0.01, "v_mm_s": 2, "v_sd_mm_s": 0.1, "cycles": 20},
                     {"alpha_rad": 2, "alpha_sd_rad": 0.01, "v_mm_s": 3, "v_sd_mm_s": 0.1, "cycles": 20},
                     {"alpha_rad": 3, "alpha_sd_rad": 0.01, "v_mm_s": 4, "v_sd_mm_s": 0.1, "cycles": 20}]}})");
  fit.as("fit.json");
  constexpr long few_steps = 2'000;  // of the model, which sanitizers make hundreds of times as slow
  fit.read_or_refuse([&] { apps::collect(apps::RunFolder{fit.folder.path()}, few_steps); });
}

/// A track's, and that of a fit, as `report` reads it.
void read_meta(const Hostile& hostile) {
  const auto file = hostile.as("t.csv.meta.json");
  hostile.read_or_refuse([&] { apps::track_described_by(apps::read_json(file), file); });
  hostile.folder.write("fit.json", R"({"parameters": {}, "correlation": {}, "chi2": 20.0, "dof": 25,
      "agreement": "good", "converged": true, "identifiability": {"verdict": "identifiable", "weak_directions": []},
      "runs": [{"name": "a", "kind": "displacement", "observables": []}]})");
  hostile.as("fit.json.meta.json");
  hostile.read_or_refuse([&] { apps::collect(apps::RunFolder{hostile.folder.path()}); });
}

/// Beside a meta file that is as it should be.
void read_track(const Hostile& track) {
  track.folder.write("t.csv.meta.json",
                     R"({"schema": 1, "scale": {"mm_per_px": 0.1, "mm_per_px_sd": 0.001, "source": "given"},
          "recording": {"format": "cine", "first_image": -5, "exposure_s": 0.0005, "width": 320, "height": 320},
          "time_base": {"rate_hz": 250, "source": "cine header"},
          "slow_errors": [{"from": "light", "sd_px": 0.01, "time_s": 0.1}],
          "summary": {"disc_px": [111, 92, 30], "frames": 3}})");
  const auto file = track.as("t.csv");
  track.read_or_refuse([&] { apps::read_track_file(file); });
}

/// A table of alpha and v, and the runs of a campaign that names it.
void read_alpha_v(const Hostile& table) {
  const auto campaign = table.folder.write("c.toml", "[data]\ntable = \"alpha_v.csv\"\n");
  table.as("alpha_v.csv");
  table.read_or_refuse([&] { apps::read_campaign(campaign); });
}

/// A file that is read by itself.
template <class Read>
auto alone(const char* name, const Read& read) {
  return [=](const Hostile& hostile) {
    const auto file = hostile.as(name);
    hostile.read_or_refuse([&] { read(file); });
  };
}

using Path = std::filesystem::path;
const std::map<std::string, std::function<void(const Hostile&)>> kTargets = {
    {"alpha_v_csv", read_alpha_v},
    {"calibration_json", alone("calibration.json", [](const Path& file) { apps::read_calibration(file); })},
    {"campaign_toml",
     alone("campaign.toml",
           [](const Path& file) { apps::text_of(apps::read_campaign(file).effective_configuration()); })},
    {"cine", read_cine},
    {"fit_json", read_fit},
    {"foreign_csv", alone("x.csv", read_foreign_track)},
    {"meta_json", read_meta},
    {"photron_cih", read_photron},
    {"scenario_toml", alone("scenario.toml", read_scenario)},
    {"scene_toml", alone("scene.toml", read_scene)},
    {"scope_csv", alone("scope.csv", [](const Path& file) { apps::read_scope_file(file); })},
    {"track_csv", read_track}};

}  // namespace
}  // namespace tribotrack::fuzz

#if defined(FUZZ_TARGET)
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack::fuzz;
  static const Folder folder;
  static const auto& read = kTargets.at(FUZZ_TARGET);
  read({folder, {reinterpret_cast<const char*>(data), size}});
  return 0;
}
#else
int main(int argc, char** argv) {
  using namespace tribotrack::fuzz;
  namespace fs = std::filesystem;
  if (argc != 2) return 2;
  for (const auto& [name, read] : kTargets) {
    const Folder folder;
    int files = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(argv[1]) / name)) {
      std::fprintf(stderr, "%s\n", entry.path().c_str());
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string bytes((std::istreambuf_iterator<char>(file)), {});
      read({folder, bytes});
      ++files;
    }
    if (files == 0) return 1;
  }
  return 0;
}
#endif

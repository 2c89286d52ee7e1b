#include "apps/bench/scale/scale.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "apps/bench/timing/child_process.h"
#include "model/batch.h"

namespace tribotrack::bench {

namespace fs = std::filesystem;

namespace {

constexpr int kFramesPerCycle = 25;
constexpr double kTracedUpTo = 60;  ///< s that a command takes: it is run once more to count its calls

/// Removed with all it holds, unless the user named it.
class WorkFolder {
 public:
  explicit WorkFolder(const fs::path& given) : path_(given), temporary_(given.empty()) {
    if (!temporary_) {
      fs::create_directories(path_);
      return;
    }
    std::string name = (fs::temp_directory_path() / "tribotrack-scale-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (temporary_) fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
  bool temporary_;
};

std::string text_in(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

/// The k-th of `count` different pulses: phi and dtau, rad.
std::pair<double, double> pulse(int k, int count) {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kNarrow = 0.3, kWide = 2.6;
  return {std::fmod(k * kTurn * std::numbers::phi, kTurn), kNarrow + (kWide - kNarrow) * k / count};
}

class ScaleBench {
 public:
  explicit ScaleBench(const ScaleOptions& options)
      : options_(options), folder_(options.folder), strace_(find_strace()) {
    total_ = static_cast<int>(options.recordings.size() + options.frames.size() + options.runs.size() +
                              options.points.size() + options.sweep.size());
  }

  std::vector<ScaleRow> rows() {
    recordings();
    frames();
    runs();
    points();
    scenarios();
    return rows_;
  }

 private:
  void recordings() {
    if (options_.recordings.empty()) return;
    const int most = options_.recordings.back();
    std::string scene = scene_of(3);
    for (int k = 0; k < most; ++k)
      scene += fmt::format("[[shot]]\nname = \"r{:04}\"\nphi_rad = {}\ndtau_rad = {}\nseed = {}\n", k,
                           pulse(k, most).first, pulse(k, most).second, k);
    put(folder_ / "scenes.toml", scene);
    prepare({"synth", (folder_ / "scenes.toml").string(), "-o", (folder_ / "recordings").string(),
             "--overwrite"});
    for (const int count : options_.recordings) {
      std::string campaign = campaign_head("summary", 3);
      for (int k = 0; k < count; ++k)
        campaign += fmt::format("[[run]]\nvideo = \"recordings/r{:04}.cine\"\nphi_rad = {}\ndtau_rad = {}\n",
                                k, pulse(k, most).first, pulse(k, most).second);
      put(folder_ / "campaign.toml", campaign);
      const fs::path out = folder_ / "out";
      measure("recordings", count, {"run", (folder_ / "campaign.toml").string(), "-o", out.string()}, {out});
    }
  }

  void frames() {
    for (const int count : options_.frames) {
      film(count);
      measure("frames", count, track_command(count), {});
    }
  }

  void runs() {
    for (const int count : options_.runs) {
      put(folder_ / "alpha_v.csv", table_of_runs(count));
      put(folder_ / "table.toml",
          campaign_head("summary", 20) +
              "[data]\ntable = \"alpha_v.csv\"\nalpha_sd_rad = 0.02\nv_sd_mm_s = 0.04\n");
      measure("runs", count,
              {"fit", (folder_ / "table.toml").string(), "-o", (folder_ / "fit.json").string()}, {});
    }
  }

  void points() {
    for (const int count : options_.points) {
      if (!fs::exists(track(count))) {
        film(count);
        prepare(track_command(count));
      }
      put(folder_ / "points.toml", campaign_head("trajectory", count / kFramesPerCycle) +
                                       fmt::format("[[run]]\ntrack = \"{}\"\nphi_rad = {}\ndtau_rad = {}\n",
                                                   track(count).string(), kPhi, kDtau));
      measure("points", count,
              {"fit", (folder_ / "points.toml").string(), "-o", (folder_ / "fit.json").string()}, {});
    }
  }

  void scenarios() {
    for (const int count : options_.sweep)
      measure(
          "scenarios", count,
          {"sweep", "--over", fmt::format("phi_rad=0:6:{}", count), "-o", (folder_ / "sweep.csv").string()},
          {});
  }

  /// A slice of an experiment: a small disc, a mark, no texture.
  static std::string scene_of(int cycles) {
    return fmt::format(
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\n[friction]\nmu1 = 0.1\n"
        "mu1_over_mu2 = 8\nlag_rad = 0.2\n[run]\ncycles = {}\n[video]\nwidth = 128\nheight = 128\n"
        "frame_rate_hz = 250\nexposure_s = 0.4e-3\n[camera]\nmm_per_px = 0.2\n[disc]\ndiameter_mm = 6\n"
        "[marker]\nposition_px = [18, 18]\nradius_px = 8\n",
        cycles);
  }
  static std::string campaign_head(const std::string& data, int cycles) {
    return fmt::format(
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = "
        "\"pi/2\"\n[part]\n"
        "diameter_mm = 6\n[camera]\nmarker_px = [18, 18, 8]\n[fit]\ndata = \"{}\"\ncycles = {}\n",
        data, cycles);
  }
  /// alpha and v as the model has them: what is measured is the work, not the fit.
  static std::string table_of_runs(int count) {
    std::vector<model::Scenario> scenarios;
    for (int k = 0; k < count; ++k) {
      model::Scenario scenario;
      scenario.drive.angular_frequency = 62.8;
      scenario.friction.phase = pulse(k, count).first;
      scenario.friction.pulse_width = pulse(k, count).second;
      scenario.cycles = 20;
      scenarios.push_back(scenario);
    }
    const model::BatchOutcome outcome = model::solve_batch(scenarios);
    std::string table = "phi_rad,dtau_rad,alpha_rad,v_mm_s\n";
    for (std::size_t k = 0; k < scenarios.size(); ++k)
      table += fmt::format("{},{},{},{}\n", scenarios[k].friction.phase, scenarios[k].friction.pulse_width,
                           outcome.ends[k].alpha, outcome.ends[k].v * 1e3);
    return table;
  }

  static constexpr double kPhi = 0.5, kDtau = 1.2;
  fs::path film_of(int count) const { return folder_ / fmt::format("frames{}.cine", count); }
  fs::path track(int count) const { return folder_ / fmt::format("frames{}.csv", count); }
  std::vector<std::string> track_command(int count) const {
    return {"track", film_of(count).string(), "--disc-diameter-mm", "6", "--marker", "18,18,8",
            "-o",    track(count).string()};
  }
  void film(int count) {
    if (fs::exists(film_of(count))) return;
    put(folder_ / "scene.toml",
        scene_of(count / kFramesPerCycle) +
            fmt::format("[[shot]]\nname = \"frames{}\"\nphi_rad = {}\ndtau_rad = {}\n", count, kPhi, kDtau));
    prepare({"synth", (folder_ / "scene.toml").string(), "-o", (folder_ / ".").string(), "--overwrite"});
  }

  static fs::path find_strace() {
    const char* paths = std::getenv("PATH");
    std::istringstream stream(paths != nullptr ? paths : "");
    for (std::string folder; std::getline(stream, folder, ':');)
      if (std::error_code none; fs::exists(fs::path(folder) / "strace", none))
        return fs::path(folder) / "strace";
    return {};
  }

  std::vector<std::string> command_of(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {options_.program.string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    command.insert(command.end(), {"--threads", "1", "-q"});
    return command;
  }

  ChildRun run(const std::vector<std::string>& command) const {
    const ChildRun ended = run_child(command, folder_ / "stderr.txt");
    const bool done = ended.exit_code == 0 || ended.exit_code == 4 || ended.exit_code == 5;
    if (!done)
      throw std::runtime_error(fmt::format("bench scale: {} ended with {}: {}", command[1], ended.exit_code,
                                           text_in(folder_ / "stderr.txt")));
    return ended;
  }
  void prepare(const std::vector<std::string>& arguments) const { run(command_of(arguments)); }

  /// `outputs` are removed before each run of the command.
  void measure(const std::string& series, int size, const std::vector<std::string>& arguments,
               const std::vector<fs::path>& outputs) {
    const auto clear = [&] {
      for (const fs::path& output : outputs) fs::remove_all(output);
    };
    clear();
    const ChildRun ended = run(command_of(arguments));
    ScaleRow row{series, size, ended.cpu, ended.wall, ended.memory, {}};
    clear();
    if (!strace_.empty() && row.wall < kTracedUpTo) row.file_calls = file_calls(command_of(arguments));
    rows_.push_back(row);
    if (options_.progress) options_.progress(++done_, total_);
  }

  std::optional<double> file_calls(const std::vector<std::string>& command) const {
    const fs::path calls = folder_ / "calls.txt";
    // `newfstatat(5, "", {` asks an open file for its size, as before every window that is read: nothing is
    // looked up by its name.
    const std::string count = "|grep -vcF ', \"\", {' > '" + calls.string() + "'";
    std::vector<std::string> traced = {strace_.string(),         "-f", "-qq", "-e",
                                       "trace=%file,getdents64", "-o", count};
    traced.insert(traced.end(), command.begin(), command.end());
    const ChildRun ended = run_child(traced, folder_ / "stderr.txt");
    double counted = 0;
    if (ended.exit_code < 0 || !(std::istringstream(text_in(calls)) >> counted) || counted == 0)
      return std::nullopt;  // tracing is not allowed here
    return counted;
  }

  const ScaleOptions& options_;
  const WorkFolder folder_;
  const fs::path strace_;
  int done_ = 0, total_ = 0;
  std::vector<ScaleRow> rows_;
};

}  // namespace

ScaleOptions quick_scale_options() {
  ScaleOptions options;
  options.recordings = {2, 4};
  options.frames = {100, 200};
  options.runs = {4, 8};
  options.points = {100, 200};
  options.sweep = {100, 1000};
  return options;
}

ScaleOptions full_scale_options() {
  ScaleOptions options;
  options.recordings = {1, 10, 100, 300, 1000};
  options.frames = {100, 1000, 10'000, 100'000, 1'000'000};
  options.runs = {3, 30, 300, 1000, 3000};
  options.points = options.frames;
  options.sweep = {100, 10'000, 1'000'000, 10'000'000};
  return options;
}

std::vector<ScaleRow> bench_scale(const ScaleOptions& options) {
  return ScaleBench(options).rows();
}

}  // namespace tribotrack::bench

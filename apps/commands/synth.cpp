// tribotrack synth: recordings with exactly known truth.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/files/scene_file.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/input_file.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "model/friction.h"
#include "model/parallel.h"
#include "model/trajectory.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// The scene's geometry over time: where the model's motion puts disc and platform in the picture.
class Motion {
 public:
  explicit Motion(const SceneShot& shot) : shot_(shot), trajectory_(model::integrate(lasting(shot))) {
    start_px_ =
        shot.start_px ? Eigen::Vector2d(shot.start_px->x, shot.start_px->y) : start_that_centres_the_path();
  }

  long frames() const { return frames_of(shot_); }
  double time(long frame) const { return static_cast<double>(frame) / shot_.frame_rate_hz; }
  double phase(double t) const {
    return shot_.motion.scenario.start_phase + shot_.motion.scenario.drive.angular_frequency * t;
  }

  /// The part relative to the platform, m. The first exposure begins before the run does: there the part goes
  /// on as it started, so that it rests when it starts from rest and slides when it starts sliding.
  Eigen::Vector2d part(double t) const {
    if (t < 0) return trajectory_.at(0).velocity * t;
    return trajectory_.at(std::min(t, trajectory_.end_time())).position;
  }

  /// What friction leaves of the run's own spin, rad; before the run as it starts.
  double turned(double t) const {
    if (t < 0) return trajectory_.at(0).spin * t;
    return trajectory_.at(std::min(t, trajectory_.end_time())).angle;
  }

  vision::ScenePose pose(double t) const {
    const Eigen::Vector2d platform = pixels(shot_.motion.scenario.drive.displacement(phase(t)));
    const Eigen::Vector2d disc = start_px_ + pixels(part(t)) + platform - platform_at_start();
    return {{disc.x(), disc.y()},
            shot_.theta_rad + shot_.spin_rad_s * t + turned(t),
            {platform.x(), platform.y()}};
  }

 private:
  static long frames_of(const SceneShot& shot) {
    if (shot.frames > 0) return shot.frames;
    // The last frame has to lie beyond the last whole cycle, so that it can be interpolated to.
    return static_cast<long>(std::ceil(shot.motion.scenario.end_time() * shot.frame_rate_hz)) + 4;
  }
  static model::Scenario lasting(const SceneShot& shot) {
    model::Scenario scenario = shot.motion.scenario;
    scenario.duration = (static_cast<double>(frames_of(shot)) + 1) / shot.frame_rate_hz;
    return scenario;
  }
  /// Campaign axes in m to picture axes in px: turned by xi_axis, y down.
  Eigen::Vector2d pixels(const Eigen::Vector2d& m) const {
    const Eigen::Vector2d up = Eigen::Rotation2Dd(shot_.xi_axis_rad) * m / (shot_.mm_per_px * 1e-3);
    return {up.x(), -up.y()};
  }
  Eigen::Vector2d platform_at_start() const {
    return pixels(shot_.motion.scenario.drive.displacement(phase(0)));
  }
  Eigen::Vector2d start_that_centres_the_path() const {
    Eigen::Vector2d low(0, 0), high(0, 0);
    for (long k = 0; k < frames(); ++k) {
      const Eigen::Vector2d at = pixels(part(time(k)));
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
    return Eigen::Vector2d((shot_.scene.width - 1) / 2.0, (shot_.scene.height - 1) / 2.0) - (low + high) / 2;
  }

  const SceneShot& shot_;
  model::Trajectory trajectory_;
  Eigen::Vector2d start_px_;
};

std::string truth_row(const SceneShot& shot, const Motion& motion, long frame) {
  const double t = motion.time(frame);
  const vision::ScenePose pose = motion.pose(t);
  const Eigen::Vector2d mm = motion.part(t) * 1e3;
  std::string marker = ",";
  if (shot.scene.marker)
    marker = fmt::format("{},{}", exact(shot.scene.marker->position.x + pose.platform.x),
                         exact(shot.scene.marker->position.y + pose.platform.y));
  return fmt::format("{},{},{},{},{},{},{},{}\n", frame, exact(t), exact(pose.disc.x), exact(pose.disc.y),
                     exact(pose.theta), marker, exact(mm.x()), exact(mm.y()));
}

template <class Report>
void render(const SceneShot& shot, const fs::path& video, const Report& report) {
  const Motion motion(shot);
  const vision::SceneRenderer renderer(shot.scene);
  vision::SinkOptions options = shot.sink;
  options.width = shot.scene.width;
  options.height = shot.scene.height;
  options.bits = shot.scene.bits;
  options.frame_rate_hz = shot.frame_rate_hz;
  options.exposure_s = shot.exposure_s;
  if (!vision::is_number_pattern(video)) require_writable(video, Content::pictures);
  const auto sink = vision::create_sink(video, options);

  std::string truth = "frame,time_s,x_px,y_px,theta_rad,marker_x_px,marker_y_px,x_mm,y_mm\n";
  const auto pose = [&](double t) { return motion.pose(t); };
  for (long frame = 0; frame < motion.frames(); ++frame) {
    const double t = motion.time(frame);
    const double lamp =
        model::gate_share(shot.motion.scenario.friction, motion.phase(t - shot.exposure_s / 2),
                          motion.phase(t + shot.exposure_s / 2));
    sink->write(renderer.render(frame, t, shot.exposure_s, pose, lamp));
    truth += truth_row(shot, motion, frame);
    report(motion.frames());
  }
  sink->close();
  write_file(video.string() + ".truth.csv", truth);
}

struct SynthOptions {
  std::string scene, output, extension = "cine";
  bool overwrite = false, json = false;
};

/// Refuses what would replace a recording, before anything is rendered.
void require_no_recordings(const std::vector<fs::path>& videos) {
  for (const fs::path& video : videos) {
    const auto files = files_of_input(video);
    const bool rendered = fs::exists(video.string() + ".truth.csv");  // a recording has no known truth
    if (!files.empty() && fs::exists(files.front()) && !rendered)
      throw InvalidInput(
          "{}: is there already, was not rendered by `synth`, and is not overwritten; give another name, or "
          "--overwrite",
          files.front().string());
  }
}

void synth(const SynthOptions& options, const Context& context) {
  const std::vector<SceneShot> shots = read_scene_file(options.scene);
  const Input scene = hashed_input(options.scene);
  const bool many = !shots.front().name.empty();
  if (many && names_a_recording(options.output))
    throw InvalidInput("{}: names one recording, but {} has {} [[shot]]; give a folder, and --extension {}",
                       options.output, options.scene, shots.size(),
                       fs::path(options.output).extension().string().substr(1));
  const auto video_of = [&](const SceneShot& shot) {
    return many ? fs::path(options.output) / (shot.name + "." + options.extension) : fs::path(options.output);
  };
  if (!many)
    require_writable({{options.output, Content::pictures}, {options.output + ".truth.csv"}}, {options.scene});
  std::vector<fs::path> videos;
  for (const SceneShot& shot : shots) videos.push_back(video_of(shot));
  if (!options.overwrite) require_no_recordings(videos);
  if (many) create_folder(options.output);
  Progress progress("synth", context);
  std::atomic<long> frames = 0;
  parallel_for(shots.size(), threads_to_use(context), [&](std::size_t k) {
    const SceneShot& shot = shots[k];
    render(shot, video_of(shot),
           [&](long total) { progress.update(++frames, total * static_cast<long>(shots.size())); });
    MetaFile{"synth", {scene}, json_of(shot)}.write_beside(video_of(shot));
  });
  if (options.json) {
    Json recordings = Json::array();
    for (const fs::path& video : videos)
      recordings.push_back({{"video", video.string()}, {"truth", video.string() + ".truth.csv"}});
    print_text(text_of(Json{{"recordings", recordings}, {"frames", frames.load()}}));
  }
  say(context.quiet, many ? fmt::format("{}: {} recordings", options.output, shots.size())
                          : fmt::format("{}: {} frames", options.output, frames.load()));
}

}  // namespace

void add_synth(CLI::App& app, Context& context) {
  auto options = std::make_shared<SynthOptions>();
  CLI::App& command =
      *app.add_subcommand("synth", "Render a recording with exactly known truth (VIDEO.truth.csv)");
  add_option(command, "SCENE", options->scene, "SCENE.toml",
             "Scene file (TOML); with [[shot]] entries, one recording each")
      ->required();
  add_option(command, "-o,--output", options->output, "VIDEO",
             "The recording: .cine, .mkv (FFV1), .avi (MJPEG), .mp4 (H.264), a pattern dir/%05d.png or .tif; "
             "with [[shot]] entries a folder")
      ->required();
  add_option(command, "--extension", options->extension, "EXT",
             "With [[shot]] entries: the recordings' file type (default cine)");
  command.add_flag("--json", options->json, "Print what was written as one JSON object");
  command.add_flag("--overwrite", options->overwrite, "Replace recordings of these names");
  add_common(command, context, "  tribotrack synth data/example/scene.toml -o recordings");
  command.callback([options, &context] { synth(*options, context); });
}

}  // namespace tribotrack::apps

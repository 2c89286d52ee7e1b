#include "apps/bench/vision/bench.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/vision/matching.h"
#include "apps/bench/vision/recording.h"
#include "vision/cramer_rao_bound.h"
#include "vision/registration/registration.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

using std::numbers::pi;

struct Shot {
  Scene scene;
  bool moving = false;
  Point middle;
  ScenePose pose(double frame) const {
    ScenePose p;
    const double turn = 2 * pi * frame / 37;
    p.disc = {middle.x + 3.7 * std::cos(turn) + 0.0137 * frame,
              middle.y + 3.7 * std::sin(turn) - 0.0119 * frame};
    if (moving) p.platform = {5.6 * std::cos(2 * pi * frame / 23), -5.6 * std::sin(2 * pi * frame / 23)};
    return p;
  }
  std::function<ScenePose(double)> at(int frame) const {
    return [p = pose(frame)](double) { return p; };
  }
};

Shot shot_of(double radius, bool brushed) {
  Shot shot;
  Scene& s = shot.scene;
  s.width = s.height = 2 * (static_cast<int>(std::ceil(radius)) + 16) + 1;
  s.disc.radius_px = radius;
  s.disc.level = 170;
  s.disc.edge_blur_px = 0.7;
  s.disc.scratches = 0;
  s.disc.highlight = 0;
  s.platform.level = 80;
  s.platform.texture_rms = brushed ? 10 : 0;
  shot.moving = brushed;
  shot.middle = {s.width / 2.0 - 0.3, s.height / 2.0 - 0.6};
  return shot;
}

/// Our registration by itself, from the last position, with the mask `track` would choose.
class Registered : public PositionMethod {
 public:
  Registered(const Picture& first, const Circle& disc, double noise, bool brushed)
      : disc_(disc), registration_(make(first, disc, noise, brushed)) {}
  std::string name() const override { return "tribotrack registration alone"; }
  void take(const Picture& picture) override { picture_ = picture; }
  Point locate() override {
    const Registration found = registration_.refine(picture_, 0, 0, last_);
    if (found.converged) last_ = found.pose;
    return {disc_.x + last_.dx, disc_.y + last_.dy};
  }

 private:
  static TemplateRegistration make(const Picture& first, const Circle& disc, double noise, bool brushed) {
    DiscPatternOptions mask;
    mask.margin_px = brushed ? 0 : 3;
    RegistrationOptions options;
    options.noise_variance = noise * noise + 1.0 / 12;
    return {first, disc_pattern(first, disc, mask), options};
  }
  Circle disc_;
  TemplateRegistration registration_;
  Picture picture_;
  Pose last_;
};

/// What one method found, and in what time.
struct Finding {
  std::string method;
  bool ours = false;
  std::vector<std::optional<Point>> positions;
  double time = 0;
};

Finding whole_pipeline(const std::vector<Picture>& frames, const Circle& disc, bool quick) {
  MemorySource source(frames, kFrameRate);
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = disc;
  Finding finding;
  finding.method = "tribotrack track";
  finding.ours = true;
  std::vector<double> times;
  for (int repetition = 0; repetition < (quick ? 1 : 3); ++repetition) {
    const double begin = thread_seconds();
    const TrackResult result = track(source, options);
    times.push_back((thread_seconds() - begin) / static_cast<double>(frames.size()));
    finding.positions.clear();
    for (const TrackPoint& p : result.track.points)
      finding.positions.push_back(p.status == TrackStatus::ok ? std::optional<Point>({p.x, p.y})
                                                              : std::nullopt);
  }
  finding.time = median(times);
  return finding;
}

/// All methods take turns on each frame.
std::vector<Finding> frame_by_frame(const std::vector<Picture>& frames, const Circle& disc, double noise,
                                    bool brushed) {
  auto methods = peer_position_methods(frames.front(), disc);
  methods.insert(methods.begin(), std::make_unique<Registered>(frames.front(), disc, noise, brushed));
  std::vector<Finding> findings(methods.size());
  std::vector<std::vector<double>> times(methods.size());
  for (const Picture& frame : frames)
    for (std::size_t m = 0; m < methods.size(); ++m) {
      methods[m]->take(frame);
      const double begin = thread_seconds();
      findings[m].positions.emplace_back(methods[m]->locate());
      times[m].push_back(thread_seconds() - begin);
    }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    findings[m].method = methods[m]->name();
    findings[m].ours = m == 0;
    findings[m].time = median(times[m]);
  }
  return findings;
}

/// Amplitude of a sin(2 pi x) + b cos(2 pi x) fitted to errors e at places x.
double sine_of_fraction(const std::vector<double>& places, const std::vector<double>& errors) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixX3d columns(n, 3);
  Eigen::VectorXd e(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = 2 * pi * places[static_cast<std::size_t>(i)];
    columns.row(i) << 1, std::sin(x), std::cos(x);
    e(i) = errors[static_cast<std::size_t>(i)];
  }
  const Eigen::Vector3d fit = columns.colPivHouseholderQr().solve(e);
  return std::hypot(fit(1), fit(2));
}

VisionBenchRow judge(const Finding& finding, const Shot& shot) {
  VisionBenchRow row;
  row.method = finding.method;
  row.ours = finding.ours;
  row.time = finding.time;
  row.frames = static_cast<int>(finding.positions.size());
  // Frame 0 is the template itself.
  std::vector<double> xs, ys, ex, ey;
  for (std::size_t k = 1; k < finding.positions.size(); ++k) {
    if (!finding.positions[k]) {
      ++row.lost;
      continue;
    }
    const Point truth = shot.pose(static_cast<double>(k)).disc;
    xs.push_back(truth.x);
    ys.push_back(truth.y);
    ex.push_back(finding.positions[k]->x - truth.x);
    ey.push_back(finding.positions[k]->y - truth.y);
  }
  const auto n = static_cast<Eigen::Index>(ex.size());
  if (n < 4) return row;
  const Eigen::Map<const Eigen::ArrayXd> x(ex.data(), n), y(ey.data(), n);
  row.offset = std::hypot(x.mean(), y.mean());
  row.rms = std::sqrt(((x - x.mean()).square().sum() + (y - y.mean()).square().sum()) /
                      static_cast<double>(2 * (n - 1)));
  row.peak_locking = 0.5 * (sine_of_fraction(xs, ex) + sine_of_fraction(ys, ey));
  return row;
}

double bound_of(const Shot& shot, double noise) {
  Scene scene = shot.scene;
  scene.read_noise = noise;
  const SceneRenderer renderer(scene);
  double variance = 0;
  for (const int frame : {3, 17}) variance += position_bound(renderer, 0, 0, shot.at(frame)).trace() / 4;
  return std::sqrt(variance);
}

std::vector<VisionBenchRow> bench_shot(const Shot& shot, const std::vector<Picture>& exact, double noise,
                                       double bound, bool quick) {
  std::vector<Picture> frames;
  for (std::size_t k = 0; k < exact.size(); ++k) frames.push_back(recorded(exact[k], noise, k));
  const Point start = shot.pose(0).disc;
  const Circle disc{start.x, start.y, shot.scene.disc.radius_px};
  std::vector<Finding> findings{whole_pipeline(frames, disc, quick)};
  for (Finding& finding : frame_by_frame(frames, disc, noise, shot.moving))
    findings.push_back(std::move(finding));
  std::vector<VisionBenchRow> rows;
  for (const Finding& finding : findings) {
    VisionBenchRow row = judge(finding, shot);
    row.scene = shot.moving ? "brushed, moving" : "plain";
    row.radius = disc.radius;
    row.noise = noise;
    row.bound = bound;
    rows.push_back(row);
  }
  for (VisionBenchRow& row : rows) {
    row.rms_over_ours = row.rms / rows.front().rms;
    row.time_over_ours = row.time / rows.front().time;
  }
  return rows;
}

/// OpenCV on one thread for as long as this lives.
struct OneOpenCvThread {
  int before = set_opencv_threads(1);
  ~OneOpenCvThread() { set_opencv_threads(before); }
};

}  // namespace

std::vector<VisionBenchRow> bench_vision(const VisionBenchOptions& options) {
  const OneOpenCvThread one_thread;
  const std::vector<double> radii = options.quick ? std::vector<double>{12} : std::vector<double>{12, 30, 60};
  const std::vector<double> noises = options.quick ? std::vector<double>{2} : std::vector<double>{1, 2, 4};
  const int frames = options.quick ? 24 : 148;
  const int total = 2 * static_cast<int>(radii.size() * noises.size());
  std::vector<VisionBenchRow> rows;
  int done = 0;
  for (const bool brushed : {false, true})
    for (const double radius : radii) {
      const Shot shot = shot_of(radius, brushed);
      const SceneRenderer renderer(shot.scene);
      std::vector<Picture> exact;
      for (int k = 0; k < frames; ++k) exact.push_back(renderer.render_exact(0, 0, shot.at(k)));
      for (const double noise : noises) {
        const auto more = bench_shot(shot, exact, noise, bound_of(shot, noise), options.quick);
        rows.insert(rows.end(), more.begin(), more.end());
        if (options.progress) options.progress(++done, total);
      }
    }
  return rows;
}

}  // namespace tribotrack::bench

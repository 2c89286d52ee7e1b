#include "vision/rehearsal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "vision/coding/response.h"
#include "vision/coding/smooth_path.h"
#include "vision/frame_sink.h"
#include "vision/scene.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kMostFrames = 300, kFewestFrames = 32;
constexpr double kSameCoder = 1.1;  ///< real errors over rehearsed ones, see rehearsal.h

[[noreturn]] void refuse(const SourceInfo& recording, const std::string& why) {
  throw InputError(
      fmt::format("'{}' cannot be rehearsed: {}; track it without", recording.path.string(), why));
}

/// A run of consecutive points.
struct Sample {
  std::size_t first = 0, count = 0;
};

/// The longest one in which part and mark are seen, its beginning.
Sample sample_of(const Track& track) {
  Sample best, now;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    const bool seen = p.status == TrackStatus::ok && (!track.has_marker || p.marker);
    if (!seen) now = {k + 1, 0};
    if (seen) ++now.count;
    if (now.count > best.count) best = now;
  }
  best.count = std::min(best.count, kMostFrames);
  return best;
}

/// The motion to be done once more, in the recording's pixels.
struct Motion {
  std::vector<Point> part, mark;
  double interval = 0;  ///< s
};

Motion motion_of(const Track& track, const Sample& sample) {
  std::vector<Point> part, mark;
  double part_square = 0, mark_square = 0;
  for (std::size_t k = sample.first; k < sample.first + sample.count; ++k) {
    const TrackPoint& p = track.points[k];
    part.push_back({p.x, p.y});
    part_square += 0.5 * (p.sigma_x * p.sigma_x + p.sigma_y * p.sigma_y);
    if (!track.has_marker) continue;
    mark.push_back({p.marker->x, p.marker->y});
    mark_square += p.marker->sigma * p.marker->sigma;
  }
  const auto n = static_cast<double>(sample.count);
  Motion out;
  out.part = smooth_path(part, std::sqrt(part_square / n));
  if (!mark.empty()) out.mark = smooth_path(mark, std::sqrt(mark_square / n));
  const TrackPoint &first = track.points[sample.first], &last = track.points[sample.first + sample.count - 1];
  out.interval = (last.time_s - first.time_s) / (n - 1);
  return out;
}

/// Mean and standard deviation of the levels between two distances from a place.
struct Levels {
  double mean = 0, sd = 0;
};
Levels levels_between(const Picture& picture, const Point& centre, double near, double far) {
  double sum = 0, squares = 0, count = 0;
  const int left = std::max(0, static_cast<int>(centre.x - far)),
            right = std::min(picture.width() - 1, static_cast<int>(centre.x + far) + 1);
  const int top = std::max(0, static_cast<int>(centre.y - far)),
            bottom = std::min(picture.height() - 1, static_cast<int>(centre.y + far) + 1);
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const double distance = std::hypot(x - centre.x, y - centre.y);
      if (distance < near || distance > far) continue;
      const auto level = static_cast<double>(picture.at(x, y));
      sum += level;
      squares += level * level;
      ++count;
    }
  if (count == 0) return {};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

/// Neither noise nor the coder's own error, at most even in one step, has a part in a texture's size.
double texture_beyond(double sd, double noise, double step) {
  return std::sqrt(std::max(0.0, sd * sd - noise * noise - step * step / 12));
}

Scene scene_of(const Picture& picture, const Motion& motion, const TrackSummary& summary) {
  Scene scene;
  // All of the picture: a coder decides by it which frames predict which. H.264 wants even sizes.
  scene.width = picture.width() / 2 * 2;
  scene.height = picture.height() / 2 * 2;
  const Point& at = motion.part.front();
  const double radius = summary.disc.radius, blur = std::max(0.3, summary.disc_blur), rim = 3 * blur;
  const Levels inside = levels_between(picture, at, 0, std::max(1.0, radius - rim));
  const Levels outside =
      levels_between(picture, at, radius + rim, radius + rim + std::max(4.0, 0.25 * radius));
  scene.read_noise = summary.noise_levels;  // what the coder left of it: too little rather than too much
  scene.disc.radius_px = radius;
  scene.disc.level = inside.mean;
  scene.disc.edge_blur_px = std::max(0.1, std::sqrt(std::max(0.0, blur * blur - 1.0 / 12)));
  scene.disc.scratches = 0;
  scene.disc.scratch_contrast = 0;
  scene.disc.highlight = 0;
  scene.platform.level = outside.mean;
  scene.platform.texture_rms = texture_beyond(outside.sd, summary.noise_levels, summary.coded->step);
  if (summary.marker.radius > 0 && !motion.mark.empty()) {
    const double size = summary.marker.radius;
    const Point& mark = motion.mark.front();
    MarkerAppearance& shown = scene.marker.emplace();
    shown.position = mark;
    shown.radius_px = size;
    shown.level = levels_between(picture, mark, 0, 0.4 * size).mean;
    shown.ring_level = levels_between(picture, mark, 0.6 * size, 0.9 * size).mean;
  }
  return scene;
}

/// A file of our own that is gone afterwards.
class ScratchFile {
 public:
  explicit ScratchFile(const char* extension)
      : path_(std::filesystem::temp_directory_path() / fmt::format("tribotrack_rehearsal_{}_{}{}", ::getpid(),
                                                                   static_cast<const void*>(this),
                                                                   extension)) {}
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class Rehearsal {
 public:
  Rehearsal(FrameSource& source, const TrackOptions& options, const TrackResult& real)
      : source_(source), options_(options), real_(real), sample_(sample_of(real.track)) {
    if (sample_.count < kFewestFrames)
      refuse(source.info(), fmt::format("the part is seen in only {} frames in a row", sample_.count));
    motion_ = motion_of(real.track, sample_);
  }

  /// The same settings lead to the same steps; those that a decoder tells of blocks that were not coded are
  /// predictions, and not to be matched.
  TrackResult run() {
    const Picture picture = source_.read(index_of_first());
    const SceneRenderer renderer(scene_of(picture, motion_, real_.summary));
    std::vector<Picture> pictures;
    for (std::size_t k = 0; k < motion_.part.size(); ++k) pictures.push_back(shown(renderer, k));
    return coded_and_tracked(pictures);
  }

  const Motion& motion() const { return motion_; }

 private:
  std::int64_t index_of_first() const {
    return real_.track.points[sample_.first].frame - source_.info().first_number;
  }

  Picture shown(const SceneRenderer& renderer, std::size_t k) const {
    ScenePose pose;
    pose.disc = motion_.part[k];
    if (!motion_.mark.empty())
      pose.platform = {motion_.mark[k].x - motion_.mark[0].x, motion_.mark[k].y - motion_.mark[0].y};
    return renderer.render(static_cast<std::int64_t>(k), static_cast<double>(k) * motion_.interval, 0,
                           [&](double) { return pose; });
  }

  TrackResult coded_and_tracked(const std::vector<Picture>& pictures) const {
    const Coder& coder = *source_.info().coder;
    const ScratchFile file(coder.name == "x264" ? ".mkv" : ".avi");
    const double rate = coder.playback_hz > 0 ? coder.playback_hz : 1 / motion_.interval;
    SinkOptions sink{
        .width = pictures.front().width(), .height = pictures.front().height(), .frame_rate_hz = rate};
    sink.codec = coder.name == "x264" ? Codec::h264 : Codec::mjpeg;
    sink.like = coder;
    const auto writer = create_sink(file.path(), sink);
    for (const Picture& picture : pictures) writer->write(picture);
    writer->close();
    const auto coded = open_source(file.path(), {.frame_rate_hz = 1 / motion_.interval});
    return track(*coded, options());
  }

  TrackOptions options() const {
    TrackOptions out;
    const auto circle = [](const Point& p, double radius) { return Circle{p.x, p.y, radius}; };
    out.target = {Target::Kind::disc, circle(motion_.part.front(), real_.summary.disc.radius), {}};
    out.marker.kind = MarkerChoice::Kind::none;
    if (real_.summary.marker.radius > 0 && !motion_.mark.empty())
      out.marker = {MarkerChoice::Kind::circle, circle(motion_.mark.front(), real_.summary.marker.radius)};
    else if (real_.summary.ground_is_marker)
      out.marker.kind = MarkerChoice::Kind::texture;
    out.min_ncc = options_.min_ncc;
    out.layers = real_.summary.layered ? options_.layers : Layers::off;
    return out;
  }

  FrameSource& source_;
  const TrackOptions& options_;
  const TrackResult& real_;
  Sample sample_;
  Motion motion_;
};

/// Seen and true paths where both are there.
struct Compared {
  std::vector<Point> part, true_part, mark, true_mark;
  std::vector<char> type;
};

Compared compare(const TrackResult& seen, const Motion& motion) {
  Compared out;
  for (std::size_t k = 0; k < seen.track.points.size() && k < motion.part.size(); ++k) {
    const TrackPoint& p = seen.track.points[k];
    if (p.status != TrackStatus::ok) continue;
    out.part.push_back({p.x, p.y});
    out.true_part.push_back(motion.part[k]);
    out.type.push_back(p.frame_type);
    if (!p.marker || motion.mark.empty()) continue;
    out.mark.push_back({p.marker->x, p.marker->y});
    out.true_mark.push_back({motion.mark[k].x, motion.mark[k].y});
  }
  return out;
}

/// Variances of a coordinate, px^2, by type of frame; under 0 that of all. About the mean error, which is one
/// of no displacement.
std::map<char, double> variances_of(const Compared& c) {
  const auto n = static_cast<double>(c.part.size());
  Point mean;
  for (std::size_t k = 0; k < c.part.size(); ++k) {
    mean.x += (c.part[k].x - c.true_part[k].x) / n;
    mean.y += (c.part[k].y - c.true_part[k].y) / n;
  }
  struct Sum {
    double square = 0, count = 0;
  };
  std::map<char, Sum> sums;
  for (std::size_t k = 0; k < c.part.size(); ++k)
    for (const char type : {c.type[k], char{0}}) {
      Sum& sum = sums[type];
      sum.square += std::pow(c.part[k].x - c.true_part[k].x - mean.x, 2) +
                    std::pow(c.part[k].y - c.true_part[k].y - mean.y, 2);
      sum.count += 2;
    }
  constexpr double kFewest = 16;  // frames of a type
  std::map<char, double> out;
  for (const auto& [type, sum] : sums)
    if (sum.count >= 2 * kFewest || type == 0) out[type] = sum.square / sum.count;
  return out;
}

double rehearsed(const std::map<char, double>& variances, char type) {
  const auto own = variances.find(type);
  return own == variances.end() ? variances.at(0) : own->second;
}

/// The rehearsal's variance in place of the rule's, but never less than the recording itself supports.
void replace(TrackPoint& p, double variance) {
  const double covariance = p.rho_xy * p.sigma_x * p.sigma_y;
  const auto along = [&](double& sigma, double& coding) {
    const double own = std::max(0.0, sigma * sigma - coding);
    coding = std::max(0.0, variance - own);
    sigma = std::sqrt(own + coding);
  };
  along(p.sigma_x, p.coding_x);
  along(p.sigma_y, p.coding_y);
  p.rho_xy = covariance / (p.sigma_x * p.sigma_y);
}

void take_over(const std::map<char, double>& variances, TrackResult& result) {
  TrackSummary& summary = result.summary;
  double added = 0, count = 0;
  for (TrackPoint& p : result.track.points) {
    if (p.status != TrackStatus::ok) continue;
    replace(p, kSameCoder * kSameCoder * rehearsed(variances, p.frame_type));
    added += 0.5 * (p.coding_x + p.coding_y);
    ++count;
  }
  CodedErrors& coded = *summary.coded;
  coded.added_sd = std::sqrt(added / std::max(1.0, count));
  std::erase_if(summary.slow, [](const SlowPart& part) { return part.from == "coder"; });
  if (coded.added_sd > 0 && coded.slow_time > 0)
    summary.slow.push_back({"coder", coded.added_sd, coded.slow_time});
  for (CodedErrors::OfType& type : coded.types)
    type.rehearsed_sd = std::sqrt(rehearsed(variances, type.type));
}

}  // namespace

void require_rehearsable(const SourceInfo& recording) {
  if (!recording.coder) return;
  if (!recording.coder->known)
    refuse(recording, fmt::format("its coder ({}) does not tell its settings", recording.coder->name));
  if (recording.bits != 8) refuse(recording, "it has more than 8 bits");
}

void rehearse(FrameSource& source, const TrackOptions& options, TrackResult& result) {
  if (!result.summary.coded) return;
  require_rehearsable(source.info());
  if (!(result.summary.disc.radius > 0)) refuse(source.info(), "the part is not a disc");
  Rehearsal rehearsal(source, options, result);
  const TrackResult seen = rehearsal.run();
  const Compared compared = compare(seen, rehearsal.motion());
  if (compared.part.size() < kFewestFrames) refuse(source.info(), "the part was lost in the rehearsal");
  take_over(variances_of(compared), result);
  CodedErrors& coded = *result.summary.coded;
  coded.rehearsed = true;
  coded.part = coded_response(compared.part, compared.true_part, rehearsal.motion().interval);
  if (compared.mark.size() >= kFewestFrames)
    coded.mark = coded_response(compared.mark, compared.true_mark, rehearsal.motion().interval);
  auto& warnings = result.summary.warnings;
  std::erase_if(warnings, [](const std::string& w) { return w.starts_with("coded by "); });
  warnings.push_back(fmt::format(
      "coded by {}: rehearsed with {} frames, this coding adds {:.4f} px; it shows the part's motion {:.2g} "
      "% "
      "too small and {:.2g} s late",
      coded.coder, compared.part.size(), coded.added_sd, 100 * coded.part->attenuation, coded.part->delay));
}

}  // namespace tribotrack::vision

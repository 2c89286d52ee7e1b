#include "vision/edge/edge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "vision/edge/rays.h"
#include "vision/kernels/parallel.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewest = 12;  ///< frames to learn from
constexpr const char* kTooFew = "too few frames show the whole edge";
constexpr std::size_t kLearnt = 512,
                      kBlock = 64;  ///< frames learnt from at most, and consecutive ones of them
constexpr std::size_t kLevels = std::size_t{1}
                                << 24;  ///< numbers kept of these: some 300 MB with their bands
constexpr int kSlopeRounds = 2;         ///< the gradient of the mean picture settles before
constexpr int kRounds = 4;              ///< of learning: positions settle in three
constexpr int kOpticsEvery = 2;         ///< rounds
constexpr int kIterations = 50, kMoreIterations = 20;  ///< of the variances, first and again
constexpr std::size_t kAtOnce = 16;                    ///< frames that one thread samples
constexpr double kNear = 0.05;                         ///< px from where a frame was sampled: M is linear
constexpr int kPasses = 3;                             ///< of a frame that lies farther
constexpr double kLongest = 1;                         ///< px a frame is moved at once

class EdgeTracking {
 public:
  EdgeTracking(FrameSource& source, const SeenFrames& frames, const EdgeOptions& options)
      : source_(source),
        frames_(frames),
        options_(options),
        grid_(ray_grid(options.radius)),
        fields_(grid_) {}

  EdgeTrack run() {
    choose_frames();
    if (learning_.size() < kFewest) return std::move(out_);
    for (int round = 0; round < kRounds; ++round) {
      sample_learning_frames(round < kSlopeRounds);
      const std::vector<RaySamples> bands =
          samples_of_bands(grid_, levels_, options_.noise_variance, block_ends_);
      if (round % kOpticsEvery == 0) learn_optics(bands.back(), round > 0);
      learn_weights(bands, round == 0 ? kIterations : kMoreIterations);
      move_learning_frames();
    }
    measure();
    return std::move(out_);
  }

 private:
  void choose_frames();
  void sample_learning_frames(bool slopes);
  void learn_optics(const RaySamples& slow, bool settled);
  void learn_weights(const std::vector<RaySamples>& bands, int iterations);
  void move_learning_frames();
  void measure();
  void sample(std::size_t k, RaySampler& sampler, const RayLevels& out);
  std::vector<RaySampler> samplers() const {
    return std::vector(static_cast<std::size_t>(std::max(1, options_.threads)), RaySampler(grid_));
  }

  FrameSource& source_;
  const SeenFrames& frames_;
  EdgeOptions options_;
  RayGrid grid_;
  RayFields fields_;
  std::vector<std::size_t> usable_, learning_, block_ends_;  ///< numbers of frames; blocks of learning ones
  std::vector<Point> centres_;                               ///< of all frames
  std::vector<float> levels_;                                ///< of the learning frames, less the mean
  MeanRays mean_;
  std::vector<Eigen::MatrixXd> covariances_;  ///< of the fields
  std::array<std::array<Eigen::VectorXd, kSectors>, kBands> variances_;
  EdgeWeights weights_;
  std::mutex reading_;
  EdgeTrack out_;
};

/// All that show the whole rim; to learn from, all of them or blocks spread over the recording.
void EdgeTracking::choose_frames() {
  const RaySampler sampler(grid_);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    centres_.push_back(frames_[k].centre);
    if (source_.bounds().contains(sampler.window(frames_[k].centre))) usable_.push_back(k);
  }
  const std::size_t n = usable_.size(), most = std::clamp(kLevels / grid_.size(), kBlock, kLearnt);
  const std::size_t blocks = n <= most ? 1 : std::max<std::size_t>(2, most / kBlock);
  const std::size_t length = blocks > 1 ? kBlock : n;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = blocks > 1 ? b * (n - length) / (blocks - 1) : 0;
    for (std::size_t k = 0; k < length; ++k) learning_.push_back(usable_[first + k]);
    block_ends_.push_back(learning_.size());
  }
  out_.learnt_from = learning_.size();
}

/// About its centre.
void EdgeTracking::sample(std::size_t k, RaySampler& sampler, const RayLevels& out) {
  thread_local Picture picture;
  const Rect window = common(sampler.window(centres_[k]), source_.bounds());
  {
    const std::lock_guard lock(reading_);
    source_.read(frames_[k].index, window, picture);
  }
  sampler.sample(QuinticSpline(picture), window, centres_[k], out);
}

/// Levels less their mean over frames; the mean and, if wanted, its gradient.
void EdgeTracking::sample_learning_frames(bool slopes) {
  const std::size_t size = grid_.size(), n = learning_.size(), parts = (n + kAtOnce - 1) / kAtOnce;
  levels_.resize(n * size);
  // Sums of some frames each, so that they are the same for any number of threads.
  std::vector<MeanRays> sums(parts);
  std::vector<RaySampler> sampler = samplers();
  parallel_for(parts, options_.threads, [&](std::size_t part, std::size_t worker) {
    MeanRays& sum = sums[part];
    sum.level.assign(size, 0);
    sum.slope_x.assign(slopes ? size : 0, 0);
    sum.slope_y = sum.slope_x;
    std::vector<float> x(sum.slope_x.size()), y(x.size());
    for (std::size_t i = part * kAtOnce; i < std::min(n, (part + 1) * kAtOnce); ++i) {
      float* level = levels_.data() + i * size;
      sample(learning_[i], sampler[worker],
             {level, slopes ? x.data() : nullptr, slopes ? y.data() : nullptr});
      for (std::size_t j = 0; j < size; ++j) sum.level[j] += level[j];
      for (std::size_t j = 0; j < x.size(); ++j) {
        sum.slope_x[j] += x[j];
        sum.slope_y[j] += y[j];
      }
    }
  });
  const auto mean_of = [&](std::vector<float> MeanRays::*member) {
    std::vector<float> mean(size, 0);
    for (const MeanRays& sum : sums)
      for (std::size_t j = 0; j < size; ++j) mean[j] += (sum.*member)[j] / static_cast<float>(n);
    return mean;
  };
  mean_.level = mean_of(&MeanRays::level);
  if (slopes) {
    mean_.slope_x = mean_of(&MeanRays::slope_x);
    mean_.slope_y = mean_of(&MeanRays::slope_y);
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < size; ++j) levels_[i * size + j] -= mean_.level[j];
}

/// By the rays of the mean picture; and once positions have settled by what changes slowly along them, for
/// that ends at the edge, whatever a chamfer makes of the mean picture.
void EdgeTracking::learn_optics(const RaySamples& slow, bool settled) {
  const RaySamples samples[] = {
      samples_of_mean(grid_, mean_.level, options_.noise_variance, learning_.size()), all_round(slow)};
  out_.optics = likeliest_optics(fields_, std::span(samples).first(settled ? 2 : 1),
                                 optics_about(out_.optics, grid_.radius))
                    .optics;
  out_.radius = grid_.radius + out_.optics.edge;
  covariances_ = fields_.covariances(out_.optics, RayFields::Beside::whole_part);
}

/// Variances of the fields in each band and sector, and the weights that follow.
void EdgeTracking::learn_weights(const std::vector<RaySamples>& bands, int iterations) {
  for (std::size_t b = 0; b < kBands; ++b) {
    const std::vector<Eigen::MatrixXd>& seen = bands[b].covariances;
    for (std::size_t j = 0; j < seen.size(); ++j)
      fit_variances(seen[j], covariances_, bands[b].noise_variance, iterations, variances_[b][j]);
    weights_[b] = weigh(grid_, mean_, covariances_, variances_[b], b, bands[b].noise_variance);
  }
}

/// Their mean stays where it is: M does not say where in it the centre lies.
void EdgeTracking::move_learning_frames() {
  const std::size_t n = learning_.size();
  std::vector<float> scores(n * kScores);
  for (std::size_t i = 0; i < n; ++i)
    score(grid_, weights_, levels_.data() + i * grid_.size(), scores.data() + i * kScores);
  const std::vector<Eigen::Vector2d> shifts =
      shifts_by_bands(weights_, split_bands(scores, kScores, block_ends_));
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& s : shifts) mean += s / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d step = (shifts[i] - mean).cwiseMax(-kLongest).cwiseMin(kLongest);
    Point& centre = centres_[learning_[i]];
    centre = {centre.x + step(0), centre.y + step(1)};
  }
}

/// Every frame, about a centre that is moved first where it lies far off.
void EdgeTracking::measure() {
  const std::size_t n = usable_.size(), size = grid_.size();
  std::vector<float> scores(n * kScores);
  std::vector<RaySampler> sampler = samplers();
  std::vector<std::vector<float>> levels(sampler.size(), std::vector<float>(size));
  parallel_for(n, options_.threads, [&](std::size_t i, std::size_t worker) {
    const std::size_t k = usable_[i];
    float *at = levels[worker].data(), *to = scores.data() + i * kScores;
    const int passes = std::ranges::binary_search(learning_, k) ? 1 : kPasses;
    for (int pass = 1; pass <= passes; ++pass) {
      sample(k, sampler[worker], {at, nullptr, nullptr});
      for (std::size_t j = 0; j < size; ++j) at[j] -= mean_.level[j];
      score(grid_, weights_, at, to);
      const Eigen::Vector2d off = shift(weights_[0], to).cwiseMax(-kLongest).cwiseMin(kLongest);
      if (off.norm() < kNear || pass == passes) break;
      centres_[k] = {centres_[k].x + off(0), centres_[k].y + off(1)};
    }
  });
  const ScoredShifts found = scored_shifts(weights_, scores);
  out_.slow_sd = found.slow_sd;
  out_.slow_frames = found.slow_frames;
  out_.fixes.resize(frames_.size());
  for (std::size_t i = 0; i < n; ++i) {
    const Point& c = centres_[usable_[i]];
    out_.fixes[usable_[i]] =
        Remeasured{{c.x + found.shift[i](0), c.y + found.shift[i](1)}, found.covariance[i]};
  }
}

}  // namespace

EdgeTrack track_edge(FrameSource& source, const SeenFrames& frames, const EdgeOptions& options) {
  return EdgeTracking(source, frames, options).run();
}

namespace {

constexpr const char* kName = "edge in bands of time";
constexpr double kTurnVisible = 0.05;  ///< px rms at the rim: less rotation does not show
constexpr double kTurnOfCodec = 1;     ///< px: a codec's cells, which the part moves over, feign less
constexpr double kWorth = 1.2;         ///< of the bound: a track that is as good gains a tenth at most
constexpr double kSmallest = 6;        ///< px of radius: below, rays from all sides meet

/// Whether the part turns visibly: its angles vary more over the recording than they scatter from frame to
/// frame.
bool turns(const FirstPassResult& first, const Track& track, double visible) {
  if (!first.turning) return false;
  std::vector<double> theta;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok) theta.push_back(first.looks[k].theta);
  double mean = 0, total = 0, white = 0;
  const auto n = static_cast<double>(theta.size());
  for (const double t : theta) mean += t / n;
  for (std::size_t k = 0; k < theta.size(); ++k) {
    total += std::pow(theta[k] - mean, 2) / n;
    if (k > 0) white += 0.5 * std::pow(theta[k] - theta[k - 1], 2) / (n - 1);
  }
  return total - white > std::pow(visible / first.disc.radius, 2);
}

/// Why the edge need not be looked at; empty where it must.
std::string reason_against(const FirstPassResult& first, const TrackOptions& options, bool coded,
                           bool turning) {
  if (options.layers == Layers::off) return "switched off with the second pass";
  if (first.blur <= 0) return "the part has no measured round edge";
  if (first.disc.radius < kSmallest) return "the part is too small";
  if (coded && !turning) return "the part does not turn visibly, and lossy compression moves an edge as well";
  return {};
}

/// Pictures of a part that turns hold what turns with it, and do not know: what the edge's own errors leave
/// of the difference is theirs, px. Of a part that does not turn it may be the edge's, which takes the noise
/// of neighbouring pixels for independent: a coder, a mosaic or an enlargement makes it alike.
double errors_of_pictures(const Remeasurement& by_edge, double stated) {
  return std::max(stated, std::sqrt(std::max(0.0, std::pow(by_edge.differ, 2) - std::pow(by_edge.sd, 2))));
}

/// About its centre; places are those of the edge that is seen.
EdgeTrack track_outer(FrameSource& source, SeenFrames frames, EdgeOptions options, const OuterEdge& outer) {
  options.radius += outer.beyond;
  for (FirstPassFrame& f : frames) f.centre = {f.centre.x + outer.off.x, f.centre.y + outer.off.y};
  EdgeTrack edge = track_edge(source, frames, options);
  for (auto& fix : edge.fixes)
    if (fix) fix->centre = {fix->centre.x - outer.off.x, fix->centre.y - outer.off.y};
  return edge;
}

}  // namespace

EdgeOutcome edge_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                       StageClock& clock, double stated, Track& track) {
  const bool coded = source.info().coder.has_value(),
             turning = turns(first, track, coded ? kTurnOfCodec : kTurnVisible);
  EdgeOutcome out;
  PlanStage& stage = out.stage;
  stage = {.name = kName, .reason = reason_against(first, options, coded, turning)};
  if (!stage.reason.empty()) return out;
  const auto running = clock.enter("edge in bands");
  const SeenFrames frames = seen_frames(track, first.first_index);
  if (frames.size() < kFewest) {
    stage.reason = kTooFew;
    return out;
  }
  const EdgeOptions asked{
      .radius = first.disc.radius, .noise_variance = first.noise_variance, .threads = options.threads};
  // Those of a part that turns may drift all the same.
  if (!turning && stated < kWorth * first.limit_px) {
    stage.reason = fmt::format("the part's pictures give {:.2g} px, noise alone allows {:.2g} px", stated,
                               first.limit_px);
    return out;
  }
  out.outer = outer_edge(source, frames, asked.radius, first.blur, asked.noise_variance, options.chamfer);
  OuterEdge& outer = *out.outer;
  const EdgeTrack edge =
      outer.measured ? track_outer(source, frames, asked, outer) : track_edge(source, frames, asked);
  if (edge.fixes.empty()) {
    stage.reason = kTooFew;
    return out;
  }
  const double beyond = edge.radius - asked.radius;
  if (outer.measured && std::abs(beyond - outer.beyond) < 2 * outer.beyond_sd) {
    outer.beyond = beyond;  // what changes along the rays tells both better
    if (edge.optics.chamfer > 0.5 * outer.widest) outer.widest = edge.optics.chamfer;
  }
  const Remeasurement change = compare(track, frames, edge.fixes);
  const double of_track = turning ? errors_of_pictures(change, stated) : stated;
  stage.on = change.sd < of_track;
  stage.reason = fmt::format(
      "learnt from {} frames: edge at {:.2f} px, blur {:.2f} px, chamfer {:.2f} px; predicted errors: {:.2g} "
      "px by the edge, of "
      "them {:.2g} px slow, {:.2g} px by the part's pictures; they differ by {:.2g} px rms",
      edge.learnt_from, edge.radius, edge.optics.blur, edge.optics.chamfer, change.sd, edge.slow_sd, of_track,
      change.differ);
  if (!stage.on) return out;
  replace(track, frames, edge.fixes);
  out.limit_px = change.median_sd;
  out.slow_sd = edge.slow_sd;
  const double duration = track.points.back().time_s - track.points.front().time_s;
  out.slow_time =
      edge.slow_frames * duration / static_cast<double>(std::max<std::size_t>(1, frames.size() - 1));
  return out;
}

}  // namespace tribotrack::vision

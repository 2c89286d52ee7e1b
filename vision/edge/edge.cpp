#include "vision/edge/edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

#include "vision/edge/bands.h"
#include "vision/kernels/dense.h"
#include "vision/kernels/parallel.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewest = 12;  ///< frames to learn from
constexpr std::size_t kLearnt = 512,
                      kBlock = 64;  ///< frames learnt from at most, and consecutive ones of them
constexpr int kRounds = 4;          ///< positions settle in three
constexpr int kSlopeRounds = 2;     ///< the gradient of the mean picture settles before
constexpr int kShapeEvery = 2;      ///< rounds
constexpr int kIterations = 50, kMoreIterations = 20;  ///< of the variances, first and again
constexpr std::size_t kSectors = 16;
constexpr int kOpticsIterations = 20;
constexpr double kEdgeReach = 1.25, kCoarse = 0.5, kFine = 0.1;  ///< px about the circle given; steps
constexpr double kSharpest = 0.4;                                ///< px: a pixel alone blurs by 0.29
constexpr double kWidestChamfer = 0.08;                          ///< of the radius
constexpr double kOfLevels = 0.1;                                ///< grey levels^2 that no field explains
constexpr double kAlike = 6;  ///< px of the rim over which fields have like variances
/// Lamps leave patterns of low azimuthal order, which resemble a shift more than independent rays would.
constexpr std::array<double, kBands> kLowOrders = {1, 8, 8};
constexpr std::size_t kRun = 64;  ///< frames either way that share a covariance
constexpr double kNear = 0.05;    ///< px from the place a frame was sampled at: linear

using Rays = Eigen::Map<const Eigen::MatrixXf, 0, Eigen::OuterStride<>>;

/// Weights and gradient at each place of the grid.
struct BandWeights {
  std::vector<float> x, y;          ///< S^-1 grad M
  Eigen::Matrix2d shift_per_score;  ///< A
  std::array<Eigen::Matrix2d, kSectors> information;
};

/// What the frames share.
struct EdgeModel {
  std::vector<float> mean, slope_x, slope_y;
  std::array<BandWeights, kBands> bands;
};

/// Of a frame: sum over each sector of D . w, for each band, along x and y.
constexpr std::size_t kScores = kBands * kSectors * 2;

struct RaySamples;
class EdgeTracking {
 public:
  EdgeTracking(FrameSource& source, const std::vector<FirstPassFrame>& frames, const EdgeOptions& options)
      : source_(source),
        frames_(frames),
        options_(options),
        grid_(ray_grid(options.radius)),
        fields_(grid_) {}

  EdgeTrack run() {
    choose_frames();
    if (learning_.size() < kFewest) {
      out_.why_not = "too few frames show the whole rim";
      return std::move(out_);
    }
    for (int round = 0; round < kRounds; ++round) {
      sample_learning_frames(round < kSlopeRounds);
      const std::vector<RaySamples> bands = band_samples();
      if (round % kShapeEvery == 0) learn_optics();
      learn_weights(bands, round);
      move_learning_frames();
    }
    measure();
    return std::move(out_);
  }

 private:
  void choose_frames();
  void sample_learning_frames(bool slopes);
  RaySamples mean_samples() const;
  std::vector<RaySamples> band_samples() const;
  void learn_optics();
  void learn_weights(const std::vector<RaySamples>& bands, int round);
  void weigh(std::size_t band, double noise_variance);
  void move_learning_frames();
  void measure();
  void sample(std::size_t k, const Point& centre, RaySampler& sampler, const RayLevels& out);
  void score(const float* levels, float* scores) const;
  std::size_t sector_of(std::size_t azimuth) const {
    return azimuth * kSectors / static_cast<std::size_t>(grid_.azimuths);
  }

  FrameSource& source_;
  const std::vector<FirstPassFrame>& frames_;
  EdgeOptions options_;
  RayGrid grid_;
  RayFields fields_;
  std::vector<std::size_t> usable_, learning_, block_ends_;  ///< numbers of frames; blocks of learning ones
  std::vector<Point> centres_;                               ///< of all frames
  std::vector<float> levels_;                                ///< of the learning frames
  EdgeModel model_;
  std::array<std::array<Eigen::VectorXd, kSectors>, kBands> variances_;
  std::vector<Eigen::MatrixXd> pieces_;
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
  const std::size_t n = usable_.size(), blocks = n <= kLearnt ? 1 : kLearnt / kBlock,
                    length = std::min(n, blocks > 1 ? kBlock : n);
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = blocks > 1 ? b * (n - length) / (blocks - 1) : 0;
    for (std::size_t k = 0; k < length; ++k) learning_.push_back(usable_[first + k]);
    block_ends_.push_back(learning_.size());
  }
  out_.learnt_from = learning_.size();
}

void EdgeTracking::sample(std::size_t k, const Point& centre, RaySampler& sampler, const RayLevels& out) {
  thread_local Picture picture;
  const Rect window = common(sampler.window(centre), source_.bounds());
  {
    const std::lock_guard lock(reading_);
    source_.read(frames_[k].index, window, picture);
  }
  sampler.sample(QuinticSpline(picture), window, centre, out);
}

/// Levels less their mean over frames; mean and, if wanted, gradient of the model.
void EdgeTracking::sample_learning_frames(bool slopes) {
  const std::size_t size = grid_.size(), n = learning_.size();
  levels_.resize(n * size);
  const auto workers = static_cast<std::size_t>(std::max(1, options_.threads));
  std::vector<RaySampler> samplers(workers, RaySampler(grid_));
  // Sums of blocks of frames, so that they are the same for any number of threads.
  constexpr std::size_t kAtOnce = 16;
  const std::size_t parts = (n + kAtOnce - 1) / kAtOnce;
  std::vector<std::vector<float>> sum_x(slopes ? parts : 0), sum_y(sum_x.size());
  parallel_for(parts, options_.threads, [&](std::size_t part, std::size_t worker) {
    std::vector<float> x(slopes ? size : 0), y(x.size());
    if (slopes) {
      sum_x[part].assign(size, 0);
      sum_y[part].assign(size, 0);
    }
    for (std::size_t i = part * kAtOnce; i < std::min(n, (part + 1) * kAtOnce); ++i) {
      const std::size_t k = learning_[i];
      sample(k, centres_[k], samplers[worker],
             {levels_.data() + i * size, slopes ? x.data() : nullptr, slopes ? y.data() : nullptr});
      for (std::size_t j = 0; j < x.size(); ++j) {
        sum_x[part][j] += x[j];
        sum_y[part][j] += y[j];
      }
    }
  });
  const auto mean_of = [&](const auto& row, std::size_t rows) {
    std::vector<double> sum(size, 0);
    for (std::size_t i = 0; i < rows; ++i) {
      const float* at = row(i);
      for (std::size_t j = 0; j < size; ++j) sum[j] += at[j];
    }
    std::vector<float> mean(size);
    for (std::size_t j = 0; j < size; ++j) mean[j] = static_cast<float>(sum[j] / static_cast<double>(n));
    return mean;
  };
  model_.mean = mean_of([&](std::size_t i) { return levels_.data() + i * size; }, n);
  if (slopes) {
    model_.slope_x = mean_of([&](std::size_t i) { return sum_x[i].data(); }, parts);
    model_.slope_y = mean_of([&](std::size_t i) { return sum_y[i].data(); }, parts);
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < size; ++j) levels_[i * size + j] -= model_.mean[j];
}

/// Weighted means of what each ray gives, about the middle of each sector's first ray.
std::vector<Eigen::MatrixXd> over_sectors(const RayGrid& grid, const std::vector<Eigen::MatrixXf>& of_ray) {
  const auto n = static_cast<double>(of_ray.size());
  const double width = std::max(kAlike, n / (2 * kSectors));
  std::vector<Eigen::MatrixXd> out;
  for (std::size_t j = 0; j < kSectors; ++j) {
    const double middle = static_cast<double>(j) * n / kSectors;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(grid.places()),
                                                static_cast<Eigen::Index>(grid.places()));
    double total = 0;
    for (std::size_t p = 0; p < of_ray.size(); ++p) {
      double apart = std::abs(static_cast<double>(p) - middle);
      apart = std::min(apart, n - apart);
      if (apart > 3 * width) continue;
      const double weight = std::exp(-0.5 * std::pow(apart / width, 2));
      sum += weight * of_ray[p].cast<double>();
      total += weight;
    }
    out.push_back(sum / total);
  }
  return out;
}

/// Sample covariances of rays about each sector, of the mean picture or of a band.
struct RaySamples {
  std::vector<Eigen::MatrixXd> covariances;
  double noise_variance = 0;
  bool whole_part = true;  ///< fields that cross the chamfer are among those that vary
  double count = 0;        ///< of independent rays, about
};

/// -2 log of the likelihood of a rim's optics.
double cost_of(const RayFields& fields, const RimOptics& optics, const RaySamples& rays) {
  const std::vector<Eigen::MatrixXd> pieces = fields.covariances(optics, rays.whole_part);
  double sum = 0;
  for (const Eigen::MatrixXd& c : rays.covariances) {
    Eigen::VectorXd start;
    sum += fit_variances(c, pieces, rays.noise_variance, kOpticsIterations, start);
  }
  return sum * rays.count / kSectors;
}

RaySamples EdgeTracking::mean_samples() const {
  const auto places = static_cast<Eigen::Index>(grid_.places());
  std::vector<Eigen::MatrixXf> of_ray;
  for (int p = 0; p < grid_.azimuths; ++p) {
    const Eigen::Map<const Eigen::VectorXf> ray(model_.mean.data() + p * places, places);
    of_ray.emplace_back(ray * ray.transpose());
  }
  return {over_sectors(grid_, of_ray),
          options_.noise_variance / static_cast<double>(learning_.size()) + kOfLevels, false,
          grid_.azimuths / kAlike};
}

std::vector<RaySamples> EdgeTracking::band_samples() const {
  const std::size_t size = grid_.size(), n = learning_.size(), places = grid_.places();
  const Bands bands = split_bands(levels_, size, block_ends_);
  const std::array<double, kBands> shares = noise_shares(block_ends_);
  std::vector<RaySamples> out;
  for (std::size_t b = 0; b < kBands; ++b) {
    std::vector<Eigen::MatrixXf> of_ray;
    for (std::size_t p = 0; p < static_cast<std::size_t>(grid_.azimuths); ++p) {
      const Rays ray(bands[b].data() + p * places, static_cast<Eigen::Index>(places),
                     static_cast<Eigen::Index>(n), Eigen::OuterStride<>(static_cast<Eigen::Index>(size)));
      of_ray.emplace_back(ray * ray.transpose() / static_cast<float>(n));
    }
    out.push_back({over_sectors(grid_, of_ray), options_.noise_variance * shares[b], true,
                   grid_.azimuths / kAlike * static_cast<double>(n) * shares[b]});
  }
  return out;
}

/// Of greatest likelihood for the rays of the mean picture: from the best of a coarse grid downhill along the
/// axes.
void EdgeTracking::learn_optics() {
  const RaySamples mean = mean_samples();
  RimOptics best = out_.optics;
  double least = std::numeric_limits<double>::infinity();
  const auto improves = [&](const RimOptics& trial) {
    if (trial.blur < kSharpest || trial.chamfer < 0) return false;
    const double cost = cost_of(fields_, trial, mean);
    if (!(cost < least)) return false;
    least = cost;
    best = trial;
    return true;
  };
  for (double chamfer = 0; chamfer < kWidestChamfer * grid_.radius; chamfer = std::max(0.5, 2 * chamfer))
    for (double edge = -kEdgeReach; edge <= kEdgeReach + chamfer; edge += kCoarse)
      improves({edge, out_.optics.blur, chamfer});
  for (double step = kCoarse; step > kFine; step /= 2)
    for (bool moved = true; moved;) {
      moved = false;
      for (const double sign : {-1.0, 1.0}) {
        const double d = sign * step;
        moved |= improves({best.edge + d, best.blur, best.chamfer});
        moved |= improves({best.edge, best.blur * (1 + 0.5 * d), best.chamfer});
        moved |= improves({best.edge, best.blur, best.chamfer + d});
        moved |= improves({best.edge + d / 2, best.blur, best.chamfer + d});  // the inner edge stays
      }
    }
  out_.optics = best;
  out_.radius = grid_.radius + best.edge;
  pieces_ = fields_.covariances(best, true);
}

/// Variances of the fields in each band and sector, and the weights that follow.
void EdgeTracking::learn_weights(const std::vector<RaySamples>& bands, int round) {
  for (std::size_t b = 0; b < kBands; ++b) {
    for (std::size_t j = 0; j < kSectors; ++j)
      fit_variances(bands[b].covariances[j], pieces_, bands[b].noise_variance,
                    round == 0 ? kIterations : kMoreIterations, variances_[b][j]);
    weigh(b, bands[b].noise_variance);
  }
}

void EdgeTracking::weigh(std::size_t band, double noise_variance) {
  const auto places = static_cast<Eigen::Index>(grid_.places());
  BandWeights& out = model_.bands[band];
  out.x.resize(grid_.size());
  out.y.resize(grid_.size());
  out.information.fill(Eigen::Matrix2d::Zero());
  for (int p = 0; p < grid_.azimuths; ++p) {
    const double at = static_cast<double>(p) * kSectors / grid_.azimuths, share = at - std::floor(at);
    const auto j = static_cast<std::size_t>(at);
    const Eigen::VectorXd v =
        (1 - share) * variances_[band][j] + share * variances_[band][(j + 1) % kSectors];
    Eigen::MatrixXd covariance = kLowOrders[band] * field_covariance(pieces_, v);
    covariance.diagonal().array() += noise_variance;
    Eigen::MatrixXd gradient(places, 2);
    gradient.col(0) =
        Eigen::Map<const Eigen::VectorXf>(model_.slope_x.data() + p * places, places).cast<double>();
    gradient.col(1) =
        Eigen::Map<const Eigen::VectorXf>(model_.slope_y.data() + p * places, places).cast<double>();
    const Eigen::MatrixXd weight = solve_spd(covariance, gradient);
    Eigen::Map<Eigen::VectorXf>(out.x.data() + p * places, places) = weight.col(0).cast<float>();
    Eigen::Map<Eigen::VectorXf>(out.y.data() + p * places, places) = weight.col(1).cast<float>();
    out.information[sector_of(static_cast<std::size_t>(p))] += weight.transpose() * gradient;
  }
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const auto& i : out.information) sum += i;
  out.shift_per_score = inverse_of(Eigen::MatrixXd(sum));
}

/// Levels less the mean, weighed.
void EdgeTracking::score(const float* levels, float* scores) const {
  const std::size_t places = grid_.places();
  std::fill(scores, scores + kScores, 0.0F);
  for (std::size_t p = 0; p < static_cast<std::size_t>(grid_.azimuths); ++p) {
    const std::size_t first = p * places;
    for (std::size_t b = 0; b < kBands; ++b) {
      const BandWeights& w = model_.bands[b];
      float x = 0, y = 0;
      for (std::size_t i = first; i < first + places; ++i) {
        x += levels[i] * w.x[i];
        y += levels[i] * w.y[i];
      }
      float* to = scores + 2 * (b * kSectors + sector_of(p));
      to[0] += x;
      to[1] += y;
    }
  }
}

/// Shift of one frame in a band, from its scores.
Eigen::Vector2d shift(const BandWeights& weights, const float* scores) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t j = 0; j < kSectors; ++j) sum += Eigen::Vector2d(scores[2 * j], scores[2 * j + 1]);
  return weights.shift_per_score * sum;
}

const float* of_band(const Bands& bands, std::size_t band, std::size_t row) {
  return bands[band].data() + row * kScores + band * kSectors * 2;
}

void EdgeTracking::move_learning_frames() {
  const std::size_t n = learning_.size();
  std::vector<float> scores(n * kScores);
  for (std::size_t i = 0; i < n; ++i) score(levels_.data() + i * grid_.size(), scores.data() + i * kScores);
  const Bands bands = split_bands(scores, kScores, block_ends_);
  std::vector<Eigen::Vector2d> shifts(n, Eigen::Vector2d::Zero());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t b = 0; b < kBands; ++b) shifts[i] += shift(model_.bands[b], of_band(bands, b, i));
    mean += shifts[i] / static_cast<double>(n);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d step = (shifts[i] - mean).cwiseMax(-1).cwiseMin(1);
    Point& centre = centres_[learning_[i]];
    centre.x -= step(0);
    centre.y -= step(1);
  }
}

/// Frames over which a slow series stays alike: where its correlation has fallen to 1 / e.
double frames_alike(const Bands& bands, std::size_t rows) {
  double at_once = 0;
  for (std::size_t lag = 0; lag < rows; lag += std::max<std::size_t>(1, lag / 8)) {
    double sum = 0;
    for (std::size_t k = 0; k + lag < rows; ++k) {
      const float *a = of_band(bands, kBands - 1, k), *b = of_band(bands, kBands - 1, k + lag);
      for (std::size_t j = 0; j < 2 * kSectors; ++j) sum += static_cast<double>(a[j]) * b[j];
    }
    sum /= static_cast<double>(rows - lag);
    if (lag == 0) at_once = sum;
    if (sum < at_once / std::exp(1.0)) return static_cast<double>(lag);
  }
  return static_cast<double>(rows);
}

/// How much more than independent sectors the scores of a band vary in the low azimuthal orders next to that
/// of a shift, which cannot be seen apart from it.
double low_order_excess(const Bands& bands, std::size_t band, std::size_t rows) {
  double low = 0, white = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const float* z = of_band(bands, band, i);
    for (const int order : {2, 3}) {
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (std::size_t j = 0; j < kSectors; ++j) {
        const double phi = 2 * std::numbers::pi * (static_cast<double>(j) + 0.5) / kSectors;
        const double radial = z[2 * j] * std::cos(phi) + z[2 * j + 1] * std::sin(phi);
        sum += radial * Eigen::Vector2d(std::cos(order * phi), std::sin(order * phi));
        if (order == 2) white += radial * radial;
      }
      low += 0.5 * sum.squaredNorm();
    }
  }
  return std::max(1.0, low / std::max(white, 1e-30));
}

/// Every frame at its centre, which is moved first where it lies far from the frame's place.
void EdgeTracking::measure() {
  const std::size_t n = usable_.size(), size = grid_.size();
  std::vector<float> scores(n * kScores);
  const auto workers = static_cast<std::size_t>(std::max(1, options_.threads));
  std::vector<RaySampler> samplers(workers, RaySampler(grid_));
  std::vector<std::vector<float>> levels(workers, std::vector<float>(size));
  parallel_for(n, options_.threads, [&](std::size_t i, std::size_t worker) {
    const std::size_t k = usable_[i];
    float *at = levels[worker].data(), *to = scores.data() + i * kScores;
    for (int pass = 0; pass < 3; ++pass) {
      sample(k, centres_[k], samplers[worker], {at, nullptr, nullptr});
      for (std::size_t j = 0; j < size; ++j) at[j] -= model_.mean[j];
      score(at, to);
      const Eigen::Vector2d off = shift(model_.bands[0], to).cwiseMax(-1).cwiseMin(1);
      if (off.norm() < kNear || pass == 2 || std::ranges::binary_search(learning_, k)) break;
      centres_[k].x -= off(0);
      centres_[k].y -= off(1);
    }
  });
  const std::size_t whole[] = {n};
  Bands bands = split_bands(scores, kScores, whole);
  out_.fixes.resize(frames_.size());
  for (const std::size_t k : usable_) out_.fixes[k] = EdgeFix{centres_[k], Eigen::Matrix2d::Zero()};
  for (std::size_t b = 0; b < kBands; ++b) {
    const BandWeights& w = model_.bands[b];
    std::vector<float> squares(n * 3);
    Eigen::Matrix2d overall = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      float* z = bands[b].data() + i * kScores + b * kSectors * 2;
      const Eigen::Vector2d d = shift(w, z);
      Point& centre = out_.fixes[usable_[i]]->centre;
      centre.x -= d(0);
      centre.y -= d(1);
      Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
      for (std::size_t j = 0; j < kSectors; ++j) {
        const Eigen::Vector2d left = Eigen::Vector2d(z[2 * j], z[2 * j + 1]) - w.information[j] * d;
        z[2 * j] = static_cast<float>(left(0));
        z[2 * j + 1] = static_cast<float>(left(1));
        sum += left * left.transpose();
      }
      const Eigen::Matrix2d v =
          w.shift_per_score * sum * w.shift_per_score.transpose() * (kSectors / (kSectors - 2.0));
      squares[3 * i] = static_cast<float>(v(0, 0));
      squares[3 * i + 1] = static_cast<float>(v(0, 1));
      squares[3 * i + 2] = static_cast<float>(v(1, 1));
      overall += v / static_cast<double>(n);
    }
    const double excess = low_order_excess(bands, b, n);
    overall *= excess;
    for (std::size_t i = 0; i < n; ++i) {
      Eigen::Matrix2d v = overall;
      if (b + 1 < kBands) {
        const std::size_t first = i < kRun ? 0 : i - kRun, last = std::min(n, i + kRun + 1);
        v.setZero();
        for (std::size_t m = first; m < last; ++m)
          v +=
              Eigen::Matrix2d{{squares[3 * m], squares[3 * m + 1]}, {squares[3 * m + 1], squares[3 * m + 2]}};
        v *= excess / static_cast<double>(last - first);
      }
      out_.fixes[usable_[i]]->covariance += v;
    }
    if (b + 1 == kBands) out_.slow_sd = std::sqrt(0.5 * overall.trace());
  }
  out_.slow_frames = frames_alike(bands, n);
}

}  // namespace

EdgeTrack track_edge(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                     const EdgeOptions& options) {
  return EdgeTracking(source, frames, options).run();
}

}  // namespace tribotrack::vision
